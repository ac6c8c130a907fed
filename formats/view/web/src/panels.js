/** Which curves stand together: sections of panels, each panel of one quantity and unit. */
import { readable } from "./elements.js";

const SECTIONS = { constraints: "Constraint drift", integrator: "Steps of the integrator", "interface forces": "Interface forces", reactions: "Reactions of joints" };

/** What a unit measures, in words. */
function kind(unit, { length, mass, time }, isEnergy) {
  const force = `${mass}*${length}/${time}^2`;
  const words = {
    [length]: "lengths", [`${length}/${time}`]: "speeds", [`${length}/${time}^2`]: "accelerations", rad: "angles",
    [`rad/${time}`]: "angular speeds", [`rad/${time}^2`]: "angular accelerations", [force]: "forces",
    [`${mass}*${length}^2/${time}^2`]: isEnergy ? "energies" : "moments", [`${mass}*${length}^2/${time}^3`]: "power",
    [time]: "times", [`1/${time}`]: "rates", 1: "numbers",
  };
  return words[unit] ?? "values";
}

const isEnergyHistory = ({ name, columns }) => name.startsWith("energy/") || columns.some((column) => column.name === "kinetic");

/**
 * Sections `{title, isOpen, sources}` of a description's histories. A source has a name and panels
 * `{title, unit, isLog, curves: [{name, times, values}]}`; those of one source are shown together.
 */
export function sections(description, arrays) {
  const units = description.units;
  const made = new Map();
  const section = (title, isOpen) => made.get(title) ?? made.set(title, { title, isOpen, sources: new Map() }).get(title);
  const panel = (where, source, key, make) => {
    const panels = where.sources.get(source) ?? where.sources.set(source, new Map()).get(source);
    return panels.get(key) ?? panels.set(key, { curves: [], ...make() }).get(key);
  };
  const histories = description.histories ?? [];
  const balance = histories.find((history) => history.name.startsWith("energy/"));
  for (const history of histories) {
    const isEnergy = isEnergyHistory(history);
    const times = arrays.view(history.times ?? description.times);
    const curves = history.columns.map((column) => ({ column: column.name, times, values: arrays.view(column.values) }));
    const unit = readable(history.unit, isEnergy);
    const word = kind(history.unit, units, isEnergy);
    const plain = history.title.replace(` (${history.quantity})`, "");
    if (history === balance) {
      const where = section("Energy", true);
      const energies = panel(where, "", "energies", () => ({ title: "Energies of the whole mechanism", unit, isLog: false }));
      const defect = panel(where, "", "defect", () => ({ title: "Defect of the energy balance, without its sign", unit, isLog: true }));
      for (const curve of curves) (curve.column === "defect" ? defect : energies).curves.push({ ...curve, name: curve.column || plain });
      continue;
    }
    if (history.quantity === "outputs") {
      if (isEnergy && balance && isSame(curves, balance, arrays)) continue;
      const target = panel(section("Outputs", true), "", `${word} ${history.unit}`, () => ({ title: `Outputs: ${word}`, unit, isLog: false }));
      for (const curve of curves) target.curves.push({ ...curve, name: curve.column ? `${plain}.${curve.column}` : plain });
      continue;
    }
    const isCheck = history.quantity === "constraints" || history.quantity === "integrator";
    const title = SECTIONS[history.quantity] ?? history.quantity[0].toUpperCase() + history.quantity.slice(1);
    const where = section(isCheck ? "Constraint drift and steps" : title, false);
    for (const curve of curves) {
      const of = isCheck ? `${title}: ${curve.column.replaceAll("_", " ") || word}` : `${title}: ${plain}, ${word}`;
      const source = isCheck ? "" : plain;
      const target = panel(where, source, isCheck ? of : history.unit, () => ({ title: of, unit, isLog: history.quantity === "constraints" }));
      target.curves.push({ ...curve, name: curve.column.replaceAll("_", " ") || plain });
    }
  }
  const inOrder = [...made.values()].sort((a, b) => Number(b.isOpen) - Number(a.isOpen));
  return inOrder.map(({ title, isOpen, sources }) => ({
    title, isOpen, sources: [...sources].map(([name, panels]) => ({ name, panels: [...panels.values()].filter((one) => one.curves.length > 0) })),
  }));
}

/** Whether an output only repeats the energy balance. */
function isSame(curves, balance, arrays) {
  return curves.length === balance.columns.length && curves.every((curve, k) => {
    const other = arrays.view(balance.columns[k].values);
    return curve.column === balance.columns[k].name && other.length === curve.values.length && other.every((value, at) => value === curve.values[at]);
  });
}
