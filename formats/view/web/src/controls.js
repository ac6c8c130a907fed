/** The buttons and sliders of the view. */
import { gradient } from "./colours.js";
import { element, number } from "./elements.js";

const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 4];
const COLOURS = [["none", "Colour: bodies"], ["deflection", "Colour: deflection"], ["strain", "Colour: strain"], ["speed", "Colour: speed"]];

export class Controls {
  /** @param viewer what they steer @param {{isPart: boolean, modes: object[]}} what */
  constructor(viewer, { isPart, modes, hasTime, canFilm }) {
    this.viewer = viewer;
    const button = (text, label, action, extra = {}) => element("button", { type: "button", "aria-label": label, title: label, onclick: action, ...extra }, text);
    this.play = button("▶", "Play (space)", () => viewer.toggle());
    this.slider = element("input", { type: "range", min: 0, max: 1000, step: 1, value: 0, class: "time", "aria-label": isPart ? "Phase of the mode" : "Time", oninput: () => viewer.seek(this.slider.value / 1000) });
    this.time = element("output", { class: "now" });
    this.speed = element("select", { "aria-label": "Speed", onchange: () => viewer.setSpeed(Number(this.speed.value)) },
      ...SPEEDS.map((value) => element("option", { value, selected: value === 1 }, `${value}×`)));
    this.scale = element("input", { type: "number", min: 0, step: "any", class: "scale", "aria-label": "Scale of the deflection", onchange: () => viewer.setScale(Number(this.scale.value)) });
    this.colour = element("select", { "aria-label": "Colour", onchange: () => viewer.setColour(this.colour.value) },
      ...COLOURS.filter(([value]) => !(isPart && value === "speed")).map(([value, text]) => element("option", { value }, text)));
    this.views = element("select", { "aria-label": "View", onchange: () => { viewer.look(this.views.value); this.views.value = ""; } },
      ...[["", "View"], ["home", "Home"], ["front", "Front"], ["back", "Back"], ["left", "Left"], ["right", "Right"], ["top", "Top"], ["bottom", "Bottom"]].map(([value, text]) => element("option", { value }, text)));
    const glyphs = element("input", { type: "checkbox", checked: true, onchange: () => viewer.showGlyphs(glyphs.checked) });
    this.legend = element("div", { class: "legend", hidden: true }, element("span"), element("i"), element("span"));
    this.legend.children[1].style.background = gradient();
    this.told = element("p", { class: "told", "aria-live": "polite" });
    this.modes = modes.length === 0 ? null : element("select", { "aria-label": "Mode", class: "modes", onchange: () => viewer.setMode(Number(this.modes.value)) },
      ...modes.map((mode, index) => element("option", { value: index }, mode.frequency == null ? mode.name : `${mode.name}: ${number(mode.frequency)} Hz`)));
    const row = element("div", { class: "bar", role: "group", "aria-label": "View controls" });
    if (this.modes) row.append(this.modes);
    if (hasTime) row.append(this.play, this.slider, this.time, this.speed);
    row.append(
      element("label", {}, isPart ? "size " : "deflection × ", this.scale), this.colour, this.views,
      element("label", {}, glyphs, " signs"),
      button("Picture", "Save a picture (PNG)", () => viewer.savePicture()),
    );
    if (canFilm) row.append((this.film = button("Film", "Save one run as a film (WebM)", () => viewer.saveFilm())));
    row.append(button("◐", "Dark or light", () => viewer.toggleTheme()), button("?", "Keys (h)", () => viewer.help()));
    this.root = element("div", { class: "controls" }, row, this.legend, this.told);
  }

  showPlaying(isPlaying) {
    this.play.textContent = isPlaying ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", isPlaying ? "Pause (space)" : "Play (space)");
  }

  showTime(fraction, text) {
    this.slider.value = Math.round(1000 * fraction);
    this.slider.setAttribute("aria-valuetext", text);
    this.time.textContent = text;
  }

  showLegend(what, largest, unit) {
    this.legend.hidden = what === "none";
    const title = { deflection: "deflection", strain: "equivalent strain in the surface", speed: "speed" }[what];
    this.legend.children[0].textContent = title ? `${title}: 0` : "";
    this.legend.children[2].textContent = `${number(largest)} ${unit}`;
  }

  tell(text) {
    this.told.textContent = text;
  }
}
