/** Charts of the description in their places. */
import uPlot from "uplot";
import { axis, line, marks, positive, recolour } from "./curves.js";
import { number } from "./elements.js";

const HEIGHT = 300;
const PRINTED = 680;

export function drawCharts(description, arrays) {
  for (const place of document.querySelectorAll("div.chart[data-chart]")) {
    const chart = description.charts?.[Number(place.dataset.chart)];
    if (chart) drawChart(place, chart, arrays);
  }
}

function drawChart(place, chart, arrays) {
  const data = [arrays.view((chart.curves[0] ?? chart.bands[0]).x)];
  const value = (_, one) => number(one);
  const series = [{ label: chart.x.label, value }];
  const bands = [];
  const along = (values) => (chart.y.log ? positive(values) : values);
  chart.bands.forEach((band) => {
    data.push(along(arrays.view(band.high)), along(arrays.view(band.low)));
    series.push({ label: `${band.name}, upper`, stroke: "#8a9ab0", width: 1, value }, { label: `${band.name}, lower`, stroke: "#8a9ab0", width: 1, value });
    bands.push({ series: [series.length - 2, series.length - 1], fill: "rgba(120, 150, 190, 0.3)" });
  });
  chart.curves.forEach((curve, k) => {
    data.push(along(arrays.view(curve.y)));
    series.push({ label: curve.name, value, ...line(k) });
  });
  const width = () => Math.max(place.clientWidth, 280);
  place.replaceChildren();
  const plot = new uPlot({
    width: width(),
    height: HEIGHT,
    scales: { x: { time: false, distr: chart.x.log ? 3 : 1, range: (_, low, high) => [low, high] }, y: { distr: chart.y.log ? 3 : 1 } },
    axes: [{ ...axis(), label: chart.x.label, ...marks(chart.x.log) }, { ...axis(), label: chart.y.label, size: 64, ...marks(chart.y.log) }],
    series, bands,
  }, data, place);
  const canvas = plot.root.querySelector("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", chart.title);
  const fit = (wanted) => plot.setSize({ width: wanted, height: HEIGHT });
  new ResizeObserver(() => fit(width())).observe(place);
  window.addEventListener("themechange", () => recolour(plot));
  window.addEventListener("beforeprint", () => fit(Math.min(width(), PRINTED)));
  window.addEventListener("afterprint", () => fit(width()));
}
