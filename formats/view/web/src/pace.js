/** How fast a run is shown: time of the motion in a second on the screen. */
import { duration } from "./elements.js";

/** Seconds that a run lasts on the screen, where nothing turns too fast for that. */
const RUN = 6;
/** Pictures a second, and the angle that the fastest body turns from one to the next, at most. */
const PICTURES = 30;
const ANGLE = (20 * Math.PI) / 180;
/** From this angle between two stored times a turning can't be told from its opposite safely. */
const APART = Math.PI / 2;
/** Seconds in a unit of time. */
const SECONDS = { s: 1, ms: 1e-3, us: 1e-6, min: 60, h: 3600 };

/** A number from 1, 2, 5, 10 ... that is not above a value. */
export function round(value) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  return power * [1, 2, 5].filter((digit) => digit * power <= value * (1 + 1e-9)).at(-1);
}

/** The fastest turning of bodies: `{rate}` in radians a unit of time, and the body whose stored times are furthest apart `{angle, body}`. */
export function turning(bodies, times) {
  const found = { rate: 0, angle: 0, body: null };
  for (const body of bodies) {
    const f = body.motion.frames;
    if (!f || f.length < 7 * times.length) continue;
    for (let k = 1; k < times.length; k++) {
      const [a, b] = [7 * k - 4, 7 * k + 3];
      const cosine = Math.min(1, Math.abs(f[a] * f[b] + f[a + 1] * f[b + 1] + f[a + 2] * f[b + 2] + f[a + 3] * f[b + 3]));
      const angle = 2 * Math.acos(cosine);
      if (angle > found.angle) Object.assign(found, { angle, body });
      if (times[k] > times[k - 1]) found.rate = Math.max(found.rate, angle / (times[k] - times[k - 1]));
    }
  }
  return found;
}

/** Speeds to choose from and the one to start with; `{rates: [[rate, text]], start, warning}`. */
export function pace(bodies, times, unit) {
  const run = times.at(-1) - times[0];
  const { rate, angle, body } = turning(bodies, times);
  const start = round(Math.min(run / RUN, rate > 0 ? (ANGLE * PICTURES) / rate : Infinity));
  const real = SECONDS[unit] ? 1 / SECONDS[unit] : null;
  const wanted = new Set([start]);
  for (const factor of [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 2, 5, 10, 20, 50]) wanted.add(round(start * factor * 1.0001));
  if (real) wanted.add(real);
  const rates = [...wanted].sort((a, b) => a - b).map((one) => [one, `1 s shows ${duration(one, unit)}${one === real ? " (real time)" : ""}`]);
  const warning = angle > APART ? `Stored times are up to ${Math.round((angle * 180) / Math.PI)}° of turning apart (${body.name}): the turning that is shown may be wrong; record more times. ` : "";
  return { rates, start, warning };
}
