/** Curves over time: one panel a quantity and unit, cursors linked. */
import uPlot from "uplot";
import { element, readable } from "./elements.js";

const STROKES = ["#1f6fb4", "#d1661b", "#2b8a3e", "#b5338a", "#7a5af5", "#0b8f8f", "#a3841a", "#c92a2a"];
const HEIGHT = 210;
/** Curves of a panel, at most. */
const MOST = 12;

export class Histories {
  constructor(place, description, arrays, seek) {
    this.place = place;
    this.seek = seek;
    this.plots = [];
    this.isTold = false;
    this.unitOfTime = description.units?.time ?? "s";
    const panels = new Map();
    for (const history of description.histories ?? []) {
      const key = JSON.stringify([history.quantity, history.unit]);
      if (!panels.has(key)) panels.set(key, { quantity: history.quantity, unit: history.unit, curves: [] });
      const times = history.times ?? description.times;
      for (const column of history.columns) {
        const name = history.columns.length > 1 || column.name ? `${history.title}${column.name ? "." + column.name : ""}` : history.title;
        panels.get(key).curves.push({ name, times: arrays.view(times), values: arrays.view(column.values) });
      }
    }
    const all = [...panels.values()];
    const outputs = all.filter((panel) => panel.quantity === "outputs");
    const first = outputs.length > 0 ? outputs : all.slice(0, 1);
    for (const panel of first) this.#panel(panel, place);
    const others = all.filter((panel) => !first.includes(panel));
    if (others.length > 0) {
      const inside = element("div");
      const details = element("details", { ontoggle: () => { if (details.open && !inside.hasChildNodes()) others.forEach((panel) => this.#panel(panel, inside)); } },
        element("summary", {}, `${others.length} more panels: ${[...new Set(others.map((panel) => panel.quantity))].join(", ")}`), inside);
      place.append(details);
    }
    new ResizeObserver(() => this.#resize()).observe(place);
    window.addEventListener("themechange", () => this.plots.forEach(({ plot }) => plot.redraw(false)));
  }

  #panel(panel, where) {
    const shown = panel.curves.slice(0, MOST);
    const unit = readable(panel.unit);
    const title = `${panel.quantity === "outputs" ? "" : panel.quantity + " "}${unit ? `[${unit}]` : ""}`.trim();
    const box = element("figure", { class: "panel" }, element("figcaption", {}, title || "outputs"));
    if (panel.curves.length > MOST) box.append(element("p", { class: "more" }, `${MOST} of ${panel.curves.length} curves; the results file has all`));
    where.append(box);
    const colour = (name) => () => getComputedStyle(document.documentElement).getPropertyValue(name);
    const axis = { stroke: colour("--ink"), grid: { stroke: colour("--faint"), width: 1 }, ticks: { stroke: colour("--faint"), width: 1 } };
    const now = element("div", { class: "at" });
    const plot = new uPlot({
      width: Math.max(where.clientWidth || this.place.clientWidth, 280),
      height: HEIGHT,
      scales: { x: { time: false } },
      cursor: { sync: { key: "times" }, drag: { x: true, y: false } },
      axes: [{ ...axis, label: `time [${this.unitOfTime}]`, labelSize: 18, size: 34 }, { ...axis, size: 64, values: (_, ticks) => ticks.map((tick) => (tick === 0 ? "0" : Math.abs(tick) >= 1e5 || Math.abs(tick) < 1e-3 ? tick.toExponential(1) : String(Number(tick.toPrecision(4))))) }],
      series: [{ label: "t" }, ...shown.map((curve, k) => ({ label: curve.name, stroke: STROKES[k % STROKES.length], width: 1.5, value: (_, value) => (value == null ? "" : Number(value.toPrecision(5)).toString()) }))],
      hooks: {
        ready: [(own) => {
          own.over.append(now);
          own.over.addEventListener("click", () => { if (own.cursor.left >= 0) this.seek(own.posToVal(own.cursor.left, "x")); });
        }],
        setScale: [() => this.#mark()],
      },
    }, [shown[0].times, ...shown.map((curve) => curve.values)], box);
    plot.root.querySelector("canvas").setAttribute("role", "img");
    plot.root.querySelector("canvas").setAttribute("aria-label", `Curves over time: ${shown.map((curve) => curve.name).join(", ")}${unit ? " in " + unit : ""}`);
    this.plots.push({ plot, now, where });
    this.#mark();
  }

  /** A further panel for what was picked; the one before goes. */
  picked(title, unit, times, curves) {
    if (this.extra) {
      this.extra.remove();
      this.plots = this.plots.filter(({ where }) => where !== this.extra);
    }
    this.extra = element("div");
    this.place.prepend(this.extra);
    const named = curves.map((curve) => ({ ...curve, times }));
    this.#panel({ quantity: title, unit, curves: named }, this.extra);
  }

  /** Marks the time of the view. */
  show(time) {
    this.time = time;
    this.#mark();
  }

  #mark() {
    if (this.time == null) return;
    for (const { plot, now } of this.plots) {
      const left = plot.valToPos(this.time, "x");
      now.style.transform = `translateX(${Number.isFinite(left) ? left : -10}px)`;
      now.hidden = !(left >= 0 && left <= plot.over.clientWidth);
    }
  }

  #resize() {
    for (const { plot, where } of this.plots) {
      const width = where.clientWidth;
      if (width > 0 && Math.abs(width - plot.width) > 1) plot.setSize({ width, height: HEIGHT });
    }
    this.#mark();
  }
}

/** Charts of the description in their places. */
export function drawCharts(description, arrays) {
  for (const place of document.querySelectorAll("div.chart[data-chart]")) {
    const chart = description.charts?.[Number(place.dataset.chart)];
    if (chart) drawChart(place, chart, arrays);
  }
}

function drawChart(place, chart, arrays) {
  const colour = (name) => () => getComputedStyle(document.documentElement).getPropertyValue(name);
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--faint"), width: 1 } };
  const data = [arrays.view((chart.curves[0] ?? chart.bands[0]).x)];
  const series = [{ label: chart.x.label }];
  const bands = [];
  const positive = (values, axis) => (axis.log ? Array.from(values, (value) => (value > 0 ? value : null)) : values);
  chart.curves.forEach((curve, k) => {
    data.push(positive(arrays.view(curve.y), chart.y));
    series.push({ label: curve.name, stroke: STROKES[k % STROKES.length], width: 1.5 });
  });
  chart.bands.forEach((band) => {
    data.push(positive(arrays.view(band.high), chart.y), positive(arrays.view(band.low), chart.y));
    series.push({ label: `${band.name}, upper`, stroke: "#8a9ab0", width: 1 }, { label: `${band.name}, lower`, stroke: "#8a9ab0", width: 1 });
    bands.push({ series: [series.length - 2, series.length - 1], fill: "rgba(120, 150, 190, 0.3)" });
  });
  const small = (_, ticks) => ticks.map((tick) => (tick == null ? null : tick === 0 ? "0" : Math.abs(tick) >= 1e4 || Math.abs(tick) < 1e-2 ? tick.toExponential(0) : String(Number(tick.toPrecision(3)))));
  place.replaceChildren();
  const plot = new uPlot({
    width: Math.max(place.clientWidth, 280),
    height: 300,
    scales: { x: { time: false, distr: chart.x.log ? 3 : 1 }, y: { distr: chart.y.log ? 3 : 1 } },
    axes: [{ ...axis, label: chart.x.label, values: small }, { ...axis, label: chart.y.label, size: 64, values: small }],
    series, bands,
  }, data, place);
  const canvas = plot.root.querySelector("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", chart.title);
  new ResizeObserver(() => plot.setSize({ width: Math.max(place.clientWidth, 280), height: 300 })).observe(place);
}
