/** Where a body is at a time: frames and amplitudes between the times that are stored. */
import { Quaternion, Vector3 } from "three";

/** Index of the interval of a time and the share of it that has passed. */
export function interval(times, time) {
  if (times.length < 2 || time <= times[0]) return [0, 0];
  if (time >= times.at(-1)) return [times.length - 2, 1];
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return [low, (time - times[low]) / (times[low + 1] - times[low])];
}

const next = new Quaternion();

/** Motion of one body. */
export class Motion {
  constructor(times, frames, rest, amplitudes, columns) {
    this.times = times;
    this.frames = frames;
    this.rest = rest;
    this.amplitudes = amplitudes;
    this.columns = columns;
  }

  /** Writes origin and turn at a time. @param {Vector3} origin @param {Quaternion} turn */
  pose(time, origin, turn) {
    const f = this.frames;
    if (!f || this.times.length < 2) {
      const r = f && f.length >= 7 ? f : this.rest;
      origin.set(r[0], r[1], r[2]);
      turn.set(r[4], r[5], r[6], r[3]);
      return;
    }
    const [k, share] = interval(this.times, time);
    const a = 7 * k;
    const b = a + 7;
    origin.set(
      f[a] + share * (f[b] - f[a]),
      f[a + 1] + share * (f[b + 1] - f[a + 1]),
      f[a + 2] + share * (f[b + 2] - f[a + 2]),
    );
    turn.set(f[a + 4], f[a + 5], f[a + 6], f[a + 3]);
    next.set(f[b + 4], f[b + 5], f[b + 6], f[b + 3]);
    turn.slerp(next, share);
  }

  /** Writes the amplitudes at a time. */
  amplitude(time, target) {
    const n = this.columns;
    if (!this.amplitudes || n === 0) return target.fill(0);
    const [k, share] = interval(this.times, time);
    const a = n * k;
    const b = this.times.length < 2 ? a : a + n;
    for (let j = 0; j < n; j++) {
      target[j] = this.amplitudes[a + j] + share * (this.amplitudes[b + j] - this.amplitudes[a + j]);
    }
    return target;
  }
}

/** Largest of the amplitudes' absolute values over the motion, column by column. */
export function largestAmplitudes(motion) {
  const largest = new Float64Array(motion.columns);
  motion.amplitudes?.forEach((value, index) => {
    const column = index % motion.columns;
    largest[column] = Math.max(largest[column], Math.abs(value));
  });
  return largest;
}

export { Quaternion, Vector3 };
