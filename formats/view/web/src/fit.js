/** What is drawn over the whole motion, as points, and the camera that sees all of it. */
import { Box3, Vector3 } from "three";

/** Times that are looked at, at most. */
const TIMES = 60;
/** Room around what is drawn. */
const ROOM = 1.07;

/** Points of the motion in the world, each with room for deflection; `{points, lowest, center}`. */
export function extent(bodies, times, up, reachOf) {
  const points = [];
  const count = Math.min(Math.max(times.length, 1), TIMES);
  const box = new Box3();
  let lowest = Infinity;
  for (let k = 0; k < count; k++) {
    const time = times.length > 1 ? times[Math.round((k * (times.length - 1)) / (count - 1))] : (times[0] ?? 0);
    for (const body of bodies) {
      body.motion.pose(time, body.group.position, body.group.quaternion);
      const reach = reachOf(body);
      for (const point of body.outlinePoints()) {
        const at = point.clone().applyQuaternion(body.group.quaternion).add(body.group.position);
        box.expandByPoint(at);
        lowest = Math.min(lowest, at.dot(up) - reach);
        points.push([at, reach]);
      }
    }
  }
  return { points, lowest: Number.isFinite(lowest) ? lowest : 0, center: box.isEmpty() ? new Vector3() : box.getCenter(new Vector3()) };
}

/**
 * Place and target of a camera that looks along a direction and sees all points.
 * @param {Vector3} direction from the target to the camera @param {number} half tangent of half the upright angle of view @param {number} aspect
 */
export function fit({ points, center }, direction, up, half, aspect) {
  const side = new Vector3().crossVectors(up, direction).normalize();
  const top = new Vector3().crossVectors(direction, side);
  const target = center.clone();
  const at = new Vector3();
  let distance = 0;
  for (let round = 0; round < 4; round++) {
    const [low, high] = [[Infinity, Infinity], [-Infinity, -Infinity]];
    let needed = 0;
    for (const [point, reach] of points) {
      at.subVectors(point, target);
      const [x, y, z] = [at.dot(side), at.dot(top), at.dot(direction)];
      needed = Math.max(needed, z + reach + ROOM * Math.max((Math.abs(x) + reach) / (half * aspect), (Math.abs(y) + reach) / half));
      const depth = distance > z ? 1 / (distance - z) : 1;
      [x, y].forEach((value, k) => {
        low[k] = Math.min(low[k], (value - reach) * depth);
        high[k] = Math.max(high[k], (value + reach) * depth);
      });
    }
    if (round === 3 || points.length === 0) return { target, distance: needed };
    const scale = distance > 0 ? distance : 1;
    target.addScaledVector(side, 0.5 * scale * (low[0] + high[0])).addScaledVector(top, 0.5 * scale * (low[1] + high[1]));
    distance = needed;
  }
  return { target, distance };
}
