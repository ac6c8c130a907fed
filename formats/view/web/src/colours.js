/** Colours over a value from 0 to 1: a perceptually even scale (viridis, by points). */
const POINTS = [
  [0.267, 0.005, 0.329], [0.283, 0.141, 0.458], [0.254, 0.265, 0.53], [0.207, 0.372, 0.553], [0.164, 0.471, 0.558],
  [0.128, 0.567, 0.551], [0.135, 0.659, 0.518], [0.267, 0.749, 0.441], [0.478, 0.821, 0.318], [0.741, 0.873, 0.15],
  [0.993, 0.906, 0.144],
];

/** Writes the colour of a fraction to three places, linear light. */
export function paint(fraction, target, at) {
  const place = Math.min(Math.max(fraction, 0), 1) * (POINTS.length - 1);
  const below = Math.min(Math.floor(place), POINTS.length - 2);
  const share = place - below;
  for (let k = 0; k < 3; k++) {
    const value = POINTS[below][k] * (1 - share) + POINTS[below + 1][k] * share;
    target[at + k] = value ** 2.2;
  }
}

/** The scale as a CSS gradient. */
export function gradient() {
  const stops = POINTS.map((point) => `rgb(${point.map((value) => Math.round(value * 255)).join(" ")})`);
  return `linear-gradient(to right, ${stops.join(", ")})`;
}

/** Colours of bodies, one after the other. */
export const BODY_COLOURS = [0x6f93b8, 0xc98a56, 0x7ba87b, 0xb27fa8, 0x9a9a6a, 0x6aa7a7, 0xc07373, 0x8f86c4];
