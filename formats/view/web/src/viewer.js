/** The view: bodies on a stage, steered by controls. */
import { Body } from "./body.js";
import { Controls } from "./controls.js";
import { element, number, readable } from "./elements.js";
import { Glyphs } from "./glyphs.js";
import { interval } from "./motion.js";
import { Shape } from "./shape.js";
import { Stage } from "./stage.js";

/** Seconds that a run lasts on the screen, and a cycle of a mode. */
const RUN = 6;
const CYCLE = 2;
/** A deflection below this part of the size is enlarged to it at first. */
const READABLE = 0.01;
/** Largest displacement of a mode over the size. */
const MODE_SIZE = 0.08;
const KEYS = "Space: play. [ and ]: a step. Arrows: turn. + and −: nearer, farther. 1 to 6: views, 0: home. Click a body: its history. h: this line.";

export class Viewer {
  constructor(place, description, arrays) {
    this.description = description;
    this.isPart = description.kind === "part";
    this.times = description.times?.length ? arrays.view(description.times) : new Float32Array(0);
    const shapes = description.shapes.map((shape) => new Shape(shape, arrays, description.size));
    this.bodies = description.bodies.map((body, index) => new Body(body, index, shapes, this.times, arrays, description.size));
    this.query = new URLSearchParams(location.search);
    this.isStill = this.query.has("still");
    this.time = Number(this.query.get("time") ?? this.times[0] ?? 0);
    this.phase = 0.25;
    this.mode = Math.min(Number(this.query.get("mode") ?? 1) - 1, (description.modes?.length ?? 1) - 1);
    this.mode = Math.max(this.mode, 0);
    this.speed = 1;
    this.colour = "none";
    this.framesDrawn = 0;
    const canvas = element("canvas", { tabindex: 0, role: "img" });
    canvas.setAttribute("aria-label", this.#spoken());
    const hasTime = this.isPart ? description.modes.length > 0 : this.times.length > 1;
    this.controls = new Controls(this, { isPart: this.isPart, modes: this.isPart ? description.modes : [], hasTime, canFilm: hasTime && !!canvas.captureStream && typeof MediaRecorder !== "undefined" });
    place.replaceChildren(canvas, this.controls.root);
    const extent = this.#extent();
    this.stage = new Stage(canvas, description, extent);
    this.stage.ground(extent.lowest);
    this.glyphs = new Glyphs(description, this.bodies, arrays, description.size);
    this.stage.scene.add(this.glyphs.group, ...this.bodies.map((body) => body.group));
    this.scale = Number(this.query.get("scale")) || this.#usualScale();
    if (this.controls.modes) this.controls.modes.value = this.mode;
    this.controls.scale.value = number(this.scale);
    if (this.query.get("colour")) this.setColour(this.query.get("colour"));
    if (this.query.get("view")) this.stage.look(this.query.get("view"));
    this.#listen(canvas);
    this.#theme(this.query.get("theme"));
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.isPlaying = hasTime && !this.isStill && !calm;
    if (hasTime) this.controls.showPlaying(this.isPlaying);
    const shown = this.scale !== 1 && !this.isPart ? `Deflections are drawn ${number(this.scale)} times as large as they are. ` : "";
    const errors = shapes.map((shape) => shape.error).filter(Number.isFinite);
    const error = errors.length > 0 ? `Displacements are within ${number(100 * Math.max(...errors))} % of the largest one. ` : "";
    this.controls.tell(`${shown}${error}Press h for keys.`);
    this.last = null;
    this.needsDraw = true;
    requestAnimationFrame((now) => this.#frame(now));
  }

  #spoken() {
    const { bodies, title } = this.description;
    const names = bodies.slice(0, 8).map((body) => body.name).join(", ");
    return this.isPart ? `3-D view of part ${title}, deflected in a mode` : `3-D view of ${title}: ${bodies.length} bodies in motion: ${names}`;
  }

  /** Middle of what is drawn, how low it reaches and how high it is, over some of the times. */
  #extent() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    const up = this.description.up;
    let lowest = Infinity;
    let highest = -Infinity;
    const count = this.times.length > 1 ? 24 : 1;
    for (let k = 0; k < count; k++) {
      const time = this.times.length > 1 ? this.times[Math.round((k * (this.times.length - 1)) / (count - 1))] : 0;
      for (const body of this.bodies) {
        body.motion.pose(time, body.group.position, body.group.quaternion);
        for (const at of body.outlinePoints()) {
          at.applyQuaternion(body.group.quaternion).add(body.group.position);
          const p = at.toArray();
          p.forEach((value, axis) => { low[axis] = Math.min(low[axis], value); high[axis] = Math.max(high[axis], value); });
          const height = p[0] * up[0] + p[1] * up[1] + p[2] * up[2];
          lowest = Math.min(lowest, height);
          highest = Math.max(highest, height);
        }
      }
    }
    return { center: low.map((value, axis) => (Number.isFinite(value) ? 0.5 * (value + high[axis]) : 0)), lowest: Number.isFinite(lowest) ? lowest : 0, height: Math.max(highest - lowest, 0) };
  }

  #usualScale() {
    if (this.isPart) return 1;
    const reach = Math.max(0, ...this.bodies.map((body) => body.reach()));
    const wanted = READABLE * this.description.size;
    if (reach === 0 || reach >= wanted) return 1;
    const factor = wanted / reach;
    if (factor > 1e6) return 1;
    const power = 10 ** Math.floor(Math.log10(factor));
    return power * [1, 2, 5].filter((digit) => digit * power <= factor).at(-1);
  }

  #listen(canvas) {
    const { stage } = this;
    new ResizeObserver(() => { stage.resize(); this.needsDraw = true; }).observe(canvas);
    stage.resize();
    stage.controls.addEventListener("change", () => (this.needsDraw = true));
    canvas.addEventListener("keydown", (event) => this.#key(event));
    let from = null;
    canvas.addEventListener("pointerdown", (event) => (from = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (from && Math.hypot(event.clientX - from[0], event.clientY - from[1]) < 4) this.#pick(event);
    });
    window.addEventListener("beforeprint", () => { this.isPlaying = false; this.draw(); });
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const turn = 0.12;
    const actions = {
      " ": () => this.toggle(), h: () => this.help(), "[": () => this.step(-1), "]": () => this.step(1),
      ArrowLeft: () => this.stage.move(-turn, 0, 1), ArrowRight: () => this.stage.move(turn, 0, 1),
      ArrowUp: () => this.stage.move(0, turn, 1), ArrowDown: () => this.stage.move(0, -turn, 1),
      "+": () => this.stage.move(0, 0, 0.87), "=": () => this.stage.move(0, 0, 0.87), "-": () => this.stage.move(0, 0, 1.15),
      0: () => this.look("home"), 1: () => this.look("front"), 2: () => this.look("back"), 3: () => this.look("left"),
      4: () => this.look("right"), 5: () => this.look("top"), 6: () => this.look("bottom"),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
    this.needsDraw = true;
  }

  #pick(event) {
    const found = this.stage.pick(event, this.bodies);
    this.pick(found?.body ?? null, found?.hit);
  }

  /** Marks a body and tells of the node nearest to the place that was hit. */
  pick(body, hit) {
    for (const one of this.bodies) one.mark(one === body);
    this.needsDraw = true;
    if (!body) return this.controls.tell("");
    const length = this.description.units.length;
    if (!body.shape || !hit || hit.object !== body.surface) {
      const at = body.group.position.toArray().map(number).join(", ");
      this.controls.tell(`${body.name}: origin at ${at} ${length}`);
      if (!this.isPart) this.onPick?.(body, null);
      return;
    }
    const local = body.group.worldToLocal(hit.point.clone());
    const vertices = hit.face ? [hit.face.a, hit.face.b, hit.face.c] : [body.shape.cells[hit.index] ?? hit.index];
    const near = vertices.map((vertex) => body.shape.vertexNode?.[vertex] ?? vertex);
    const x = body.shape.positions;
    const distance = (k) => Math.hypot(x[3 * k] - local.x, x[3 * k + 1] - local.y, x[3 * k + 2] - local.z);
    const node = near.reduce((best, k) => (distance(k) < distance(best) ? k : best));
    const u = body.shape.displacement(node, body.amplitudes);
    const place = [0, 1, 2].map((k) => number(x[3 * node + k])).join(", ");
    const deflection = this.isPart ? "" : `, deflection ${number(Math.hypot(...u))} ${length}`;
    this.controls.tell(`${body.name}, node ${body.shape.nodes[node]} at ${place} ${length} from the origin of its frame${deflection}`);
    if (!this.isPart) this.onPick?.(body, node);
  }

  toggle() {
    this.isPlaying = !this.isPlaying;
    this.last = null;
    this.controls.showPlaying(this.isPlaying);
  }

  /** @param {number} fraction of the run or of the cycle */
  seek(fraction) {
    if (this.isPart) this.phase = fraction;
    else this.time = this.times[0] + fraction * (this.times.at(-1) - this.times[0]);
    this.isPlaying = false;
    this.controls.showPlaying(false);
    this.needsDraw = true;
  }

  setTime(time) {
    const [first, last] = [this.times[0] ?? 0, this.times.at(-1) ?? 0];
    this.seek(last > first ? Math.min(Math.max((time - first) / (last - first), 0), 1) : 0);
  }

  step(direction) {
    if (this.isPart) return this.seek((this.phase + 0.05 * direction + 1) % 1);
    const [k, share] = interval(this.times, this.time);
    const index = Math.min(Math.max(k + (share > 0.5 ? 1 : 0) + direction, 0), this.times.length - 1);
    this.setTime(this.times[index]);
  }

  setSpeed(speed) { this.speed = speed; }

  setScale(scale) {
    if (Number.isFinite(scale) && scale >= 0) this.scale = scale;
    this.needsDraw = true;
  }

  setColour(what) {
    this.colour = what;
    this.controls.colour.value = what;
    this.range = this.#range();
    const { length, time } = this.description.units;
    this.controls.showLegend(what, this.range, { deflection: this.isPart ? "of the largest" : length, strain: this.isPart ? "of the largest" : "", speed: `${length}/${time}` }[what] ?? "");
    this.needsDraw = true;
  }

  setMode(index) {
    this.mode = index;
    if (this.colour !== "none") this.setColour(this.colour);
    this.needsDraw = true;
  }

  look(name) { if (name) this.stage.look(name); this.needsDraw = true; }

  showGlyphs(isShown) { this.glyphs.group.visible = isShown; this.needsDraw = true; }

  help() { this.controls.tell(KEYS); }

  toggleTheme() { this.#theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"); }

  #theme(wanted) {
    const usual = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    document.documentElement.dataset.theme = wanted === "dark" || wanted === "light" ? wanted : usual;
    this.stage.background(document.documentElement.dataset.theme === "dark" ? 0x1b2026 : 0xeef1f4);
    this.needsDraw = true;
    window.dispatchEvent(new Event("themechange"));
  }

  /** Largest value of the colours, over some of the times. */
  #range() {
    if (this.colour === "none") return 0;
    if (this.isPart) return 1;
    let largest = 0;
    for (let k = 0; k <= 12; k++) {
      const time = this.times.length > 1 ? this.times[0] + (k / 12) * (this.times.at(-1) - this.times[0]) : 0;
      for (const body of this.bodies.filter((one) => one.shape)) {
        body.motion.amplitude(time, body.amplitudes);
        for (const value of body.values(this.colour, time)) largest = Math.max(largest, value);
      }
    }
    return largest;
  }

  /** Draws the picture of now. */
  draw() {
    const { bodies } = this;
    if (this.isPart) this.#drawMode();
    else {
      for (const body of bodies) {
        body.show(this.time, this.scale);
        if (body.shape) body.colourBy(this.colour === "none" ? null : body.values(this.colour, this.time), this.range);
      }
    }
    this.glyphs.show(bodies, interval(this.times, this.time));
    this.stage.draw();
    this.framesDrawn += 1;
    const [first, last] = [this.times[0] ?? 0, this.times.at(-1) ?? 0];
    if (this.isPart) this.controls.showTime(this.phase, `${Math.round(360 * this.phase)}°`);
    else if (last > first) {
      this.controls.showTime((this.time - first) / (last - first), `${number(this.time)} ${this.description.units.time}`);
      this.onTime?.(this.time);
    }
    document.documentElement.dataset.drawn = "true";
  }

  #drawMode() {
    const mode = this.description.modes[this.mode];
    for (const body of this.bodies) {
      body.motion.pose(0, body.group.position, body.group.quaternion);
      body.amplitudes.fill(0);
      if (!mode || !body.shape) continue;
      body.deflectIn(mode.column);
      const largest = body.shape.largest[mode.column] || 1;
      const amplitude = ((MODE_SIZE * this.description.size) / largest) * this.scale;
      body.amplitudes[mode.column] = 1 / largest;
      if (this.colour !== "none") {
        const values = body.values(this.colour, 0);
        body.colourBy(values, values.reduce((most, value) => Math.max(most, value), 0));
      } else body.colourBy(null);
      body.amplitudes[mode.column] = amplitude * Math.sin(2 * Math.PI * this.phase);
      body.deflect(body.amplitudes, 1);
    }
  }

  #frame(now) {
    if (this.isPlaying) {
      const passed = this.last == null ? 0 : Math.min((now - this.last) / 1000, 0.1);
      if (this.last != null) this.stage.keepPace(now - this.last);
      this.last = now;
      this.advance(passed * this.speed);
    } else if (this.stage.sharpen()) this.needsDraw = true;
    if (this.needsDraw) {
      this.needsDraw = false;
      this.draw();
    }
    requestAnimationFrame((next) => this.#frame(next));
  }

  /** Lets time go on. @param {number} seconds on the screen */
  advance(seconds) {
    if (this.isPart) this.phase = (this.phase + seconds / CYCLE) % 1;
    else {
      const [first, last] = [this.times[0], this.times.at(-1)];
      this.time += (seconds / RUN) * (last - first);
      if (this.time > last) this.time = first;
    }
    this.needsDraw = true;
  }

  savePicture() {
    this.draw();
    const link = element("a", { href: this.stage.canvas.toDataURL("image/png"), download: "picture.png" });
    link.click();
  }

  /** Records one run. */
  saveFilm() {
    const recorder = new MediaRecorder(this.stage.canvas.captureStream(30), { mimeType: "video/webm" });
    const parts = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => {
      const address = URL.createObjectURL(new Blob(parts, { type: "video/webm" }));
      element("a", { href: address, download: "film.webm" }).click();
      this.controls.tell("The film is saved.");
    };
    this.seek(0);
    this.toggle();
    recorder.start();
    this.controls.tell("Recording one run …");
    setTimeout(() => recorder.stop(), (1000 * (this.isPart ? CYCLE : RUN)) / this.speed);
  }
}

export { readable };
