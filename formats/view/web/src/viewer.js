/** The view: bodies on a stage, steered by controls. */
import { Vector3 } from "three";
import { Body } from "./body.js";
import { Controls } from "./controls.js";
import { element, moment, number } from "./elements.js";
import { extent } from "./fit.js";
import { Glyphs } from "./glyphs.js";
import { KEYS, listen } from "./keys.js";
import { interval } from "./motion.js";
import { pace, round } from "./pace.js";
import { Outlines } from "./outlines.js";
import { Picking } from "./picking.js";
import { ends, range } from "./ranges.js";
import { Shape } from "./shape.js";
import { drawsInSoftware, Stage } from "./stage.js";

/** Cycles of a mode in a second. */
const CYCLES = [0.05, 0.1, 0.2, 0.5, 1, 2];
const CYCLE = 0.5;
/** A deflection below this part of the size is enlarged to it at first. */
const READABLE = 0.01;
/** Largest displacement of a mode over the size. */
const MODE_SIZE = 0.08;
/** Milliseconds that a hint stays. */
const HINT = 1600;

export class Viewer {
  constructor(place, description, arrays) {
    this.description = description;
    this.query = new URLSearchParams(location.search);
    this.isPart = description.kind === "part";
    this.times = description.times?.length ? arrays.view(description.times) : new Float32Array(0);
    const shapes = description.shapes.map((shape) => new Shape(shape, arrays, description.size));
    const isSlow = drawsInSoftware();
    const where = this.query.get("deflect") ?? (isSlow ? "processor" : "shader");
    this.bodies = description.bodies.map((body, index) => new Body(body, index, shapes, this.times, arrays, description.size, where));
    this.isStill = this.query.has("still");
    this.time = Number(this.query.get("time") ?? this.times[0] ?? 0);
    this.phase = 0.25;
    this.mode = Math.min(Number(this.query.get("mode") ?? 1) - 1, (description.modes?.length ?? 1) - 1);
    this.mode = Math.max(this.mode, 0);
    this.colour = "none";
    this.framesDrawn = 0;
    this.scale = Number(this.query.get("scale")) || this.#usualScale();
    const canvas = element("canvas", { tabindex: 0, role: "img", "aria-label": `${this.#spoken()}. Keys: ${KEYS}` });
    const tip = element("div", { class: "tip", hidden: true });
    this.hint = element("div", { class: "wheel", hidden: true }, "Click the picture first, or hold Ctrl, to zoom with the wheel");
    this.glyphs = new Glyphs(description, this.bodies, arrays, description.size);
    const hasTime = this.isPart ? description.modes.length > 0 : this.times.length > 1;
    const speeds = this.#speeds(hasTime);
    this.rate = speeds.start;
    this.controls = new Controls(this, {
      isPart: this.isPart, modes: this.isPart ? description.modes : [], rates: speeds.rates, hasTime,
      canFilm: hasTime && !!canvas.captureStream && typeof MediaRecorder !== "undefined",
      hasTriangles: shapes.some((shape) => shape.corners === 3), names: this.glyphs.signs.map((sign) => sign.text),
    });
    place.replaceChildren(element("div", { class: "stage" }, canvas, tip, this.hint), this.controls.root);
    this.up = new Vector3(...description.up).normalize();
    this.stage = new Stage(canvas, description, this.#extent(), isSlow);
    this.stage.ground();
    this.picking = new Picking(this, canvas, tip);
    this.outlines = new Outlines(this.bodies);
    this.stage.scene.add(this.outlines.lines, this.glyphs.group, this.picking.marker, ...this.bodies.map((body) => body.group));
    if (this.controls.modes) this.controls.modes.value = this.mode;
    this.controls.speed.value = this.rate;
    this.controls.scale.value = number(this.scale);
    if (this.query.get("colour")) this.setColour(this.query.get("colour"));
    if (this.query.get("view")) this.stage.look(this.query.get("view"));
    this.#listen(canvas);
    this.#theme(this.query.get("theme"));
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.isPlaying = hasTime && !this.isStill && !calm;
    if (hasTime) this.controls.showPlaying(this.isPlaying);
    const errors = shapes.map((shape) => shape.error).filter(Number.isFinite);
    this.fixedNotes = speeds.warning + (errors.length > 0 ? `Displacements are within ${number(100 * Math.max(...errors))} % of the largest one. ` : "");
    this.#note();
    this.last = null;
    this.needsDraw = true;
    requestAnimationFrame((now) => this.#frame(now));
  }

  #speeds(hasTime) {
    if (this.isPart) return { rates: CYCLES.map((rate) => [rate, rate === 1 ? "1 cycle a second" : `${rate} cycles a second`]), start: CYCLE, warning: "" };
    if (!hasTime) return { rates: [], start: 1, warning: "" };
    return pace(this.bodies, this.times, this.description.units.time);
  }

  #spoken() {
    const { bodies, title } = this.description;
    const names = bodies.slice(0, 8).map((body) => body.name).join(", ");
    return this.isPart ? `3-D view of part ${title}, deflected in a mode` : `3-D view of ${title}: ${bodies.length} bodies in motion: ${names}`;
  }

  #extent() {
    const reach = this.isPart ? () => (this.description.modes.length > 0 ? MODE_SIZE * this.description.size * this.scale : 0) : (body) => body.reach() * this.scale;
    return extent(this.bodies, this.times, this.up, reach);
  }

  #usualScale() {
    if (this.isPart) return 1;
    const reach = Math.max(0, ...this.bodies.map((body) => body.reach()));
    const wanted = READABLE * this.description.size;
    if (reach === 0 || reach >= wanted) return 1;
    const factor = wanted / reach;
    return factor > 1e6 ? 1 : round(factor);
  }

  #listen(canvas) {
    const { stage } = this;
    new ResizeObserver(() => { stage.resize(); this.needsDraw = true; }).observe(canvas);
    stage.resize();
    stage.controls.addEventListener("change", () => (this.needsDraw = true));
    // The wheel scrolls the page until the picture has the focus; before the camera's own listener.
    this.stage.canvas.parentElement.addEventListener("wheel", (event) => {
      if (event.ctrlKey || event.metaKey || document.activeElement === canvas) return;
      event.stopPropagation();
      this.hint.hidden = false;
      clearTimeout(this.hinting);
      this.hinting = setTimeout(() => (this.hint.hidden = true), HINT);
    }, { capture: true, passive: true });
    canvas.addEventListener("touchmove", (event) => { if (event.touches.length > 1) event.preventDefault(); }, { passive: false });
    listen(this, canvas);
    window.addEventListener("beforeprint", () => this.#print());
    window.addEventListener("afterprint", () => {
      this.paper?.remove();
      this.#theme(this.themeBefore);
    });
  }

  /** On paper: light, sharp, and with what the controls would say. */
  #print() {
    if (this.isPlaying) this.toggle();
    this.themeBefore = document.documentElement.dataset.theme;
    this.#theme("light");
    this.stage.sharpen();
    this.draw();
    const { canvas } = this.stage;
    // A copy: the picture itself is emptied when the paper gives it another size.
    this.paper?.remove();
    this.paper = element("canvas", { class: "paper", width: canvas.width, height: canvas.height, "aria-hidden": "true" });
    this.paper.getContext("2d").drawImage(canvas, 0, 0);
    canvas.after(this.paper);
  }

  pick(body, node) {
    this.picking.pick(body, node);
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

  /** @param {number} rate time of the motion, or cycles, in a second on the screen */
  setRate(rate) { this.rate = rate; }

  setScale(scale) {
    if (!(Number.isFinite(scale) && scale >= 0)) return;
    this.scale = scale;
    this.stage.extent = this.#extent();
    this.stage.ground();
    this.#note();
    this.needsDraw = true;
  }

  #note() {
    const isShown = !this.isPart && this.bodies.some((body) => body.shape);
    const deflection = isShown ? `Deflections, relative to each body's floating frame, are drawn ${this.scale === 1 ? "as large as they are" : `${number(this.scale)} times as large as they are`}. ` : "";
    this.controls.notes.textContent = `${deflection}${this.fixedNotes}Press h for keys.`;
  }

  setColour(what) {
    this.colour = what;
    this.controls.colour.value = what;
    const { length, time } = this.description.units;
    if (this.isPart) this.painted = null;
    else if (what !== "none") this.range = range(this.bodies, what, this.times);
    const unit = { deflection: length, speed: `${length}/${time}` }[what] ?? "";
    if (this.isPart) this.#paintMode();
    this.controls.showLegend(what, this.range, unit, this.isPart);
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
    const theme = wanted === "dark" || wanted === "light" ? wanted : usual;
    document.documentElement.dataset.theme = theme;
    this.stage.theme(theme === "dark");
    this.needsDraw = true;
    window.dispatchEvent(new Event("themechange"));
  }

  /** Draws the picture of now. */
  draw() {
    const { bodies } = this;
    if (this.isPart) this.#drawMode();
    else {
      for (const body of bodies) {
        body.show(this.time, this.scale);
        if (body.shape) body.colourBy(this.colour === "none" ? null : body.values(this.colour, this.time), this.range?.largest);
      }
    }
    this.outlines.show();
    this.glyphs.show(interval(this.times, this.time));
    this.picking.show(this.stage.camera);
    this.stage.draw();
    this.framesDrawn += 1;
    this.#showTime();
    document.documentElement.dataset.drawn = "true";
  }

  #showTime() {
    const [first, last] = [this.times[0] ?? 0, this.times.at(-1) ?? 0];
    const unit = this.description.units.time;
    const now = this.isPart ? `${Math.round(360 * this.phase)}°` : `${moment(this.time, last - first)} ${unit}`;
    if (this.isPart) this.controls.showTime(this.phase, now);
    else if (last > first) {
      this.controls.showTime((this.time - first) / (last - first), now);
      this.onTime?.(this.time);
    }
    if (!this.isPlaying) {
      const mode = this.description.modes?.[this.mode];
      this.controls.stamp.textContent = this.isPart
        ? `${mode ? `${mode.name}${mode.frequency == null ? "" : `, ${number(mode.frequency)} Hz`}, phase ${now}, size ${number(this.scale)}` : ""}`
        : `Time ${now}, deflections × ${number(this.scale)}`;
    }
  }

  /** Colours by the mode that is shown, once: they don't change with the phase. */
  #paintMode() {
    const key = `${this.mode} ${this.colour}`;
    if (this.painted === key) return;
    this.painted = key;
    const mode = this.description.modes[this.mode];
    for (const body of this.bodies) {
      if (!mode || !body.shape) continue;
      if (this.colour === "none") {
        body.colourBy(null);
        continue;
      }
      body.amplitudes.fill(0);
      body.amplitudes[mode.column] = 1 / (body.shape.largest[mode.column] || 1);
      const values = body.values(this.colour, 0);
      this.range = { times: 1, of: 1, ...(values ? ends([values], this.colour) : { largest: 0, peak: 0 }) };
      body.colourBy(values, this.range.largest);
    }
  }

  #drawMode() {
    const mode = this.description.modes[this.mode];
    this.#paintMode();
    for (const body of this.bodies) {
      body.motion.pose(0, body.group.position, body.group.quaternion);
      body.amplitudes.fill(0);
      if (!mode || !body.shape) continue;
      body.deflectIn(mode.column);
      const largest = body.shape.largest[mode.column] || 1;
      body.amplitudes[mode.column] = ((MODE_SIZE * this.description.size) / largest) * this.scale * Math.sin(2 * Math.PI * this.phase);
      body.deflect(body.amplitudes, 1);
    }
  }

  #frame(now) {
    if (this.isPlaying) {
      const passed = this.last == null ? 0 : Math.min((now - this.last) / 1000, 0.1);
      if (this.last != null) this.stage.keepPace(now - this.last);
      this.last = now;
      this.advance(passed);
    } else if (this.stage.sharpen()) this.needsDraw = true;
    if (this.needsDraw) {
      this.needsDraw = false;
      this.draw();
    }
    requestAnimationFrame((next) => this.#frame(next));
  }

  /** Lets time go on. @param {number} seconds on the screen */
  advance(seconds) {
    if (this.isPart) {
      this.phase += seconds * this.rate;
      if (this.phase >= 1) this.onEnd?.();
      this.phase %= 1;
    } else {
      const [first, last] = [this.times[0], this.times.at(-1)];
      this.time += seconds * this.rate;
      if (this.time > last) {
        this.time = first;
        this.onEnd?.();
      }
    }
    this.needsDraw = true;
  }

  savePicture() {
    this.draw();
    const link = element("a", { href: this.stage.canvas.toDataURL("image/png"), download: "picture.png" });
    link.click();
  }

  /** Records one run at the speed that is set. */
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
    this.onEnd = () => {
      this.onEnd = null;
      recorder.stop();
    };
  }
}
