/** Curves over time in sections and panels, cursors linked with each other and with the view. */
import uPlot from "uplot";
import { axis, line, marks, MOST, positive, recolour } from "./curves.js";
import { element, moment, number, readable } from "./elements.js";
import { sections } from "./panels.js";

const HEIGHT = 210;
const PRINTED = 680;
/** Milliseconds in which a second click makes a double click. */
const DOUBLE = 300;

export class Histories {
  /** @param seek sets the time of the view */
  constructor(place, description, arrays, seek) {
    this.place = place;
    this.seek = seek;
    this.plots = [];
    this.unitOfTime = description.units?.time ?? "s";
    this.extra = element("div");
    this.closed = [];
    place.append(
      element("p", { class: "hint" }, "Click in a curve: the view goes to that time. Drag: zoom in. Double-click: see all again. Click a name: hide or show its curve."),
      this.extra,
    );
    for (const section of sections(description, arrays)) this.#section(section);
    new ResizeObserver(() => this.#resize()).observe(place);
    window.addEventListener("themechange", () => this.plots.forEach(({ plot }) => recolour(plot)));
    window.addEventListener("beforeprint", () => this.#print());
    window.addEventListener("afterprint", () => this.#unprint());
  }

  #section({ title, isOpen, sources }) {
    if (isOpen) return sources.forEach((source) => source.panels.forEach((panel) => this.#panel(panel, this.place)));
    const inside = element("div");
    const show = (source) => {
      this.plots.filter(({ where }) => where === inside).forEach(({ plot }) => plot.destroy());
      this.plots = this.plots.filter(({ where }) => where !== inside);
      inside.replaceChildren();
      source.panels.forEach((panel) => this.#panel(panel, inside));
    };
    const fill = () => { if (!inside.hasChildNodes()) show(sources[0]); };
    const details = element("details", { ontoggle: () => { if (details.open) fill(); } });
    details.append(element("summary", {}, sources.length > 1 ? `${title} (${sources.length})` : title));
    if (sources.length > 1) {
      const choice = element("select", { "aria-label": title, onchange: () => show(sources[Number(choice.value)]) },
        ...sources.map((source, k) => element("option", { value: k }, source.name)));
      details.append(element("div", { class: "choice" }, choice));
    }
    details.append(inside);
    this.closed.push({ details, fill });
    this.place.append(details);
  }

  #panel(panel, where) {
    const shown = panel.curves.slice(0, MOST);
    const title = `${panel.title}${panel.unit ? ` [${panel.unit}]` : ""}`;
    const box = element("figure", { class: "panel" }, element("figcaption", {}, title));
    if (panel.curves.length > MOST) box.append(element("p", { class: "more" }, `${MOST} of ${panel.curves.length} curves; the results file has all`));
    where.append(box);
    const now = element("div", { class: "at" });
    const value = (_, one) => number(one);
    const visible = (own) => own.scales.x.max - own.scales.x.min;
    const data = shown.map((curve) => (panel.isLog ? positive(curve.values.map(Math.abs)) : curve.values));
    const isEmpty = panel.isLog && data.every((values) => values.every((one) => one == null));
    const plot = new uPlot({
      width: Math.max(where.clientWidth || this.place.clientWidth, 280),
      height: HEIGHT,
      scales: { x: { time: false }, y: { distr: panel.isLog && !isEmpty ? 3 : 1 } },
      cursor: { sync: { key: "times" }, drag: { x: true, y: false } },
      axes: [
        { ...axis(), label: `time [${this.unitOfTime}]`, labelSize: 18, size: 34, ...marks(false) },
        { ...axis(), size: 72, ...marks(panel.isLog && !isEmpty) },
      ],
      series: [
        { label: "t", value: (own, time) => (time == null ? "" : `${moment(time, visible(own))} ${this.unitOfTime}`) },
        ...shown.map((curve, k) => ({ label: curve.name, value, ...line(k) })),
      ],
      hooks: { ready: [(own) => this.#listen(own, now)], setScale: [() => this.#mark()] },
    }, [shown[0].times, ...(isEmpty ? shown.map((curve) => curve.values) : data)], box);
    const canvas = plot.root.querySelector("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${title} over time: ${shown.map((curve) => curve.name).join(", ")}`);
    this.plots.push({ plot, now, where });
    this.#mark();
  }

  /** A click sets the time; a double click, which shows everything again, does not. */
  #listen(plot, now) {
    plot.over.append(now);
    let waiting = null;
    plot.over.addEventListener("click", (event) => {
      clearTimeout(waiting);
      if (event.detail > 1 || plot.cursor.left < 0) return;
      const time = plot.posToVal(plot.cursor.left, "x");
      waiting = setTimeout(() => this.seek(time), DOUBLE);
    });
    plot.over.addEventListener("dblclick", () => clearTimeout(waiting));
  }

  /** A further panel for what was picked; the one before goes. */
  picked(title, unit, times, curves) {
    this.plots.filter(({ where }) => where === this.extra).forEach(({ plot }) => plot.destroy());
    this.plots = this.plots.filter(({ where }) => where !== this.extra);
    this.extra.replaceChildren();
    this.#panel({ title, unit: readable(unit), isLog: false, curves: curves.map((curve) => ({ ...curve, times })) }, this.extra);
  }

  /** Marks the time of the view. */
  show(time) {
    this.time = time;
    this.#mark();
  }

  #mark() {
    if (this.time == null) return;
    for (const one of this.plots) {
      const { plot, now } = one;
      const left = plot.valToPos(this.time, "x");
      const isSeen = left >= 0 && left <= plot.bbox.width / devicePixelRatio;
      if (isSeen !== one.isSeen) now.hidden = !isSeen;
      one.isSeen = isSeen;
      if (isSeen) now.style.transform = `translateX(${left}px)`;
    }
  }

  /** All sections, narrow enough for paper. */
  #print() {
    this.opened = this.closed.filter(({ details }) => !details.open);
    for (const { details, fill } of this.closed) {
      details.open = true;
      fill();
    }
    for (const { plot } of this.plots) plot.setSize({ width: Math.min(plot.width, PRINTED), height: HEIGHT });
    this.#mark();
  }

  #unprint() {
    for (const { details } of this.opened ?? []) details.open = false;
    this.#resize();
  }

  #resize() {
    for (const { plot, where } of this.plots) {
      const width = where.clientWidth;
      if (width > 0 && Math.abs(width - plot.width) > 1) plot.setSize({ width, height: HEIGHT });
    }
    this.#mark();
  }
}
