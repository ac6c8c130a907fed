/** HTML elements. Text is only ever set as text. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value != null) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

/** A number for people: four significant digits. */
export function number(value) {
  if (value == null || !Number.isFinite(value)) return "";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e5 ? Number(value.toPrecision(4)).toString() : value.toExponential(3).replace(/\.?0+e/, "e");
}

/** Decimals that tell multiples of a step apart. */
function decimals(step) {
  for (let count = 0; count < 15; count++) {
    const scaled = step * 10 ** count;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return count;
  }
  return 15;
}

/** Texts of ticks that stand a step apart. */
export function ticks(values, step) {
  const largest = Math.max(...values.map(Math.abs));
  if (largest !== 0 && (largest >= 1e5 || largest < 1e-3)) {
    const power = Math.floor(Math.log10(largest));
    const digits = decimals(step / 10 ** power);
    return values.map((value) => (value === 0 ? "0" : `${(value / 10 ** power).toFixed(digits)}e${power}`));
  }
  const digits = decimals(step);
  return values.map((value) => value.toFixed(digits));
}

/** Texts of ticks of a logarithmic axis; those without a place of their own stay empty. */
export function powers(values) {
  return values.map((value) => {
    if (value == null) return null;
    const size = Math.abs(value);
    return size >= 1e4 || size < 1e-2 ? value.toExponential(0) : String(Number(value.toPrecision(3)));
  });
}

/** A time inside a range, with the digits that the range needs. */
export function moment(time, range) {
  if (time == null) return "";
  const digits = range > 0 ? Math.min(Math.max(3 - Math.floor(Math.log10(range)), 0), 15) : 6;
  return time.toFixed(digits);
}

/** A length of time: 6.7 ms where the unit is s. */
export function duration(value, unit) {
  if (unit !== "s" || value >= 1) return `${number(value)} ${unit}`;
  const [factor, small] = value >= 1e-3 ? [1e3, "ms"] : value >= 1e-6 ? [1e6, "µs"] : [1e9, "ns"];
  return `${number(value * factor)} ${small}`;
}

/** A unit as people write it: kg*m/s^2 is N where lengths are in m, masses in kg and times in s. */
export function readable(unit, isEnergy = false) {
  const known = { "kg*m/s^2": "N", "kg*m^2/s^2": isEnergy ? "J" : "N·m", 1: "", "sqrt(kg)*m": "√kg·m" };
  return known[unit] ?? unit.replaceAll("*", "·").replace(/\^2/g, "²").replace(/\^3/g, "³");
}
