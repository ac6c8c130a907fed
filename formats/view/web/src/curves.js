/** How curves are drawn, in histories and in charts. */
import { powers, ticks } from "./elements.js";

const LIGHT = ["#1f6fb4", "#c4560f", "#2b8a3e", "#b5338a", "#6a45e8", "#0b8080", "#8a6d0b", "#c92a2a"];
const DARK = ["#74b6f2", "#f79a5b", "#69c97d", "#ee86cc", "#b09cff", "#4fd0d0", "#dcc04e", "#ff8a8a"];
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3]];

export const isDark = () => document.documentElement.dataset.theme === "dark";

/** Line of curve k: eight colours, then the same ones dashed. */
export function line(k) {
  return { stroke: () => (isDark() ? DARK : LIGHT)[k % LIGHT.length], dash: DASHES[Math.floor(k / LIGHT.length) % DASHES.length], width: 1.5 };
}

/** Most curves that can be told apart. */
export const MOST = LIGHT.length * DASHES.length;

/** Colours of an axis, from the page's style. */
export function axis() {
  const colour = (name) => () => getComputedStyle(document.documentElement).getPropertyValue(name);
  return { stroke: colour("--ink"), grid: { stroke: colour("--faint"), width: 1 }, ticks: { stroke: colour("--faint"), width: 1 } };
}

/** Part of the largest value below which values are rounding. */
const ROUNDING = 1e-14;
/** Smallest value of a logarithmic axis. */
const LEAST = 1e-30;

/** Values of a logarithmic axis: what is zero is left out, and what is so much smaller than the largest that it is rounding. */
export function positive(values) {
  let largest = 0;
  for (const value of values) if (value > largest && Number.isFinite(value)) largest = value;
  const least = Math.max(LEAST, ROUNDING * largest);
  return Array.from(values, (value) => (value > least ? value : null));
}

/** Decades in which only powers of ten are marked. */
const MANY = 5;

/** Ticks of a logarithmic axis: whole multiples of powers of ten, wherever it begins. uPlot's own don't end for some small values. */
function logarithmic(low, high) {
  const splits = [];
  const digits = Math.log10(high / low) > MANY ? [1] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high) + 1e-9; power++) {
    for (const digit of digits) {
      const value = Number(`${digit}e${power}`);
      if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) splits.push(value);
    }
  }
  return splits;
}

/** Where an axis has ticks and what they say. */
export function marks(isLog) {
  return isLog
    ? { splits: (_, _axis, low, high) => logarithmic(low, high), values: (_, splits) => powers(splits) }
    : { values: (_, splits, _axis, _space, step) => ticks(splits, step) };
}

/** Draws a plot again after dark has become light, marks of its legend too. */
export function recolour(plot) {
  const rows = plot.root.querySelectorAll(".u-legend .u-series");
  plot.series.forEach((series, k) => {
    const mark = rows[k]?.querySelector(".u-marker");
    if (mark && k > 0) mark.style.borderColor = series.stroke(plot, k);
  });
  plot.redraw(false);
}
