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

/** A number for people: four digits. */
export function number(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e5 ? Number(value.toPrecision(4)).toString() : value.toExponential(2);
}

/** A unit as people write it: kg*m/s^2 is N where lengths are in m, masses in kg and times in s. */
export function readable(unit) {
  const known = { "kg*m/s^2": "N", "kg*m^2/s^2": "N·m", 1: "", "sqrt(kg)*m": "√kg·m" };
  return known[unit] ?? unit.replaceAll("*", "·").replace(/\^2/g, "²").replace(/\^3/g, "³");
}
