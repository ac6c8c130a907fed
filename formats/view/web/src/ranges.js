/** The largest value of the colours over a motion. */

/** Additions that are afforded for it. */
const WORK = 4e7;
/** Times that are looked at, at least. */
const FEWEST = 13;
/** Strains peak where a load enters: their colours end at this share of the nodes. */
const SHARE = 0.99;

/** `{largest, peak, times, of}`: where the colours end, the largest value, and how many of the stored times were looked at. */
export function range(bodies, what, times) {
  const members = bodies.filter((body) => body.shape && (what !== "strain" || body.shape.corners === 3));
  const cost = members.reduce((sum, { shape }) => sum + 3 * shape.count * shape.columns.length * (what === "speed" ? 2 : 1) + (what === "strain" ? 20 * shape.cells.length : 0), 1);
  const of = Math.max(times.length, 1);
  const count = Math.min(of, Math.max(FEWEST, Math.floor(WORK / cost)));
  const peaks = members.map((body) => new Float32Array(body.shape.count));
  for (let k = 0; k < count; k++) {
    const time = times[count > 1 ? Math.round((k * (of - 1)) / (count - 1)) : 0] ?? 0;
    members.forEach((body, place) => {
      body.motion.amplitude(time, body.amplitudes);
      const values = body.values(what, time);
      const peak = peaks[place];
      for (let node = 0; node < peak.length; node++) if (values[node] > peak[node]) peak[node] = values[node];
    });
  }
  return { ...ends(peaks, what), times: count, of };
}

/** Where the colours of values at nodes end. */
export function ends(fields, what) {
  let peak = 0;
  for (const field of fields) for (const value of field) peak = Math.max(peak, value);
  return { largest: what === "strain" ? percentile(fields) : peak, peak };
}

function percentile(fields) {
  const count = fields.reduce((sum, field) => sum + field.length, 0);
  if (count === 0) return 0;
  const all = new Float32Array(count);
  let at = 0;
  for (const field of fields) {
    all.set(field, at);
    at += field.length;
  }
  all.sort();
  return all[Math.floor(SHARE * (count - 1))];
}
