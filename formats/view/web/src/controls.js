/** The buttons and sliders of the view. */
import { gradient } from "./colours.js";
import { element, number } from "./elements.js";

const COLOURS = [["none", "Colour: bodies"], ["deflection", "Colour: deflection"], ["strain", "Colour: strain"], ["speed", "Colour: speed"]];
const VIEWS = [["", "View"], ["home", "Home"], ["front", "Front"], ["back", "Back"], ["left", "Left"], ["right", "Right"], ["top", "Top"], ["bottom", "Bottom"]];
const TITLES = { deflection: "deflection from the floating frame of its body", strain: "equivalent strain in the surface", speed: "speed" };

export class Controls {
  /**
   * @param viewer what they steer
   * @param {{isPart: boolean, modes: object[], rates: [number, string][], hasTime: boolean, canFilm: boolean, hasTriangles: boolean, names: string[]}} what
   */
  constructor(viewer, { isPart, modes, rates, hasTime, canFilm, hasTriangles, names }) {
    this.viewer = viewer;
    const button = (text, label, action) => element("button", { type: "button", "aria-label": label, title: label, onclick: action }, text);
    const options = (pairs) => pairs.map(([value, text]) => element("option", { value }, text));
    this.play = button("▶", "Play (space)", () => viewer.toggle());
    this.slider = element("input", { type: "range", min: 0, max: 1000, step: 1, value: 0, class: "time", "aria-label": isPart ? "Phase of the mode" : "Time", oninput: () => viewer.seek(this.slider.value / 1000) });
    this.time = element("output", { class: "now" });
    this.speed = element("select", { "aria-label": "Speed", class: "speed", onchange: () => viewer.setRate(Number(this.speed.value)) }, ...options(rates));
    this.scale = element("input", { type: "number", min: 0, step: "any", class: "scale", "aria-label": "Scale of the deflection", onchange: () => viewer.setScale(Number(this.scale.value)) });
    const isOffered = ([value]) => !(isPart && value === "speed") && !(value === "strain" && !hasTriangles);
    this.colour = element("select", { "aria-label": "Colour", onchange: () => viewer.setColour(this.colour.value) }, ...options(COLOURS.filter(isOffered)));
    this.views = element("select", { "aria-label": "View", onchange: () => { viewer.look(this.views.value); this.views.value = ""; } }, ...options(VIEWS));
    const bodies = viewer.bodies;
    this.body = element("select", { "aria-label": "Body", class: "body", onchange: () => viewer.pick(bodies[Number(this.body.value)] ?? null, null) },
      element("option", { value: -1 }, "Body"), ...options(bodies.map((body, k) => [k, body.name])));
    this.node = element("input", { type: "number", min: 0, step: 1, class: "node", "aria-label": "Node", onchange: () => viewer.picking.pickNumber(this.node.value) });
    const glyphs = element("input", { type: "checkbox", checked: true, onchange: () => viewer.showGlyphs(glyphs.checked) });
    this.modes = modes.length === 0 ? null : element("select", { "aria-label": "Mode", class: "modes", onchange: () => viewer.setMode(Number(this.modes.value)) },
      ...options(modes.map((mode, k) => [k, mode.frequency == null ? mode.name : `${mode.name}: ${number(mode.frequency)} Hz`])));
    const time = element("div", { class: "bar run", role: "group", "aria-label": "Time" }, this.play, this.slider, this.time, this.speed);
    const row = element("div", { class: "bar", role: "group", "aria-label": "View controls" });
    if (this.modes) row.append(this.modes);
    row.append(element("label", {}, isPart ? "size " : "deflection × ", this.scale), this.colour, this.views);
    if (bodies.length > 1) row.append(this.body);
    if (bodies.some((body) => body.shape)) row.append(element("label", {}, "node ", this.node));
    row.append(element("label", {}, glyphs, " signs"), button("Picture", "Save a picture (PNG)", () => viewer.savePicture()));
    if (canFilm) row.append(button("Film", "Save one run as a film (WebM)", () => viewer.saveFilm()));
    row.append(button("◐", "Dark or light", () => viewer.toggleTheme()), button("?", "Keys (h)", () => viewer.help()));
    this.legend = element("div", { class: "legend", hidden: true }, element("span"), element("i"), element("span"));
    this.legend.children[1].style.background = gradient();
    this.stamp = element("p", { class: "stamp" });
    this.notes = element("p", { class: "notes" });
    this.told = element("p", { class: "told", "aria-live": "polite" });
    this.root = element("div", { class: "controls" }, ...(hasTime ? [time] : []), row, this.legend, this.stamp, this.told, this.notes);
    if (names.length > 0) this.root.append(this.#names(names));
  }

  #names(names) {
    const list = element("ul");
    return element("details", { class: "names", ontoggle: () => { if (!list.hasChildNodes()) list.append(...names.map((name) => element("li", {}, name))); } },
      element("summary", {}, `Names of the signs (${names.length}); the pointer over a sign shows its name too`), list);
  }

  showPlaying(isPlaying) {
    this.play.textContent = isPlaying ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", isPlaying ? "Pause (space)" : "Play (space)");
  }

  showTime(fraction, text) {
    if (text === this.time.textContent) return;
    this.slider.value = Math.round(1000 * fraction);
    this.slider.setAttribute("aria-valuetext", text);
    this.time.textContent = text;
  }

  showPicked(body, node) {
    this.body.value = body;
    this.node.value = node;
  }

  /** What the colours mean. @param range of the values @param {boolean} isRelative values are shares of the largest */
  showLegend(what, range, unit, isRelative) {
    this.legend.hidden = what === "none";
    if (what === "none") return;
    const { largest, peak, times, of } = range;
    const [title, , end] = this.legend.children;
    title.textContent = `${TITLES[what]}: 0`;
    const said = [isRelative ? `${number(peak > 0 ? largest / peak : 0)} of the largest` : `${number(largest)} ${unit}`.trim()];
    if (largest < peak) said.push(`99 % of the nodes stay below, ${isRelative ? "the rest has the last colour" : `the largest is ${number(peak)}`}`);
    if (times < of) said.push(`computed from ${times} of ${of} stored times; larger values at other times have the last colour`);
    end.textContent = said.join("; ");
  }

  tell(text) {
    this.told.textContent = text;
  }
}
