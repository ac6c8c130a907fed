/** How a point that belongs to a mesh moves when the mesh deflects. */
import { Vector3 } from "three";

/** Nodes as far away as the nearest one, up to this factor, move a point together: the rim of a bore moves its middle. */
const TOGETHER = 1.25;
const MOST = 96;

export class Follower {
  /** @param body a body of the view or null @param {number[]} position body axes @param {number} size of everything */
  constructor(body, position, size) {
    this.body = body;
    this.position = new Vector3(...position);
    this.patterns = body?.shape ? patterns(body.shape, position, size) : null;
  }

  /** Writes where it is now, in the world, with the deflection as it is drawn. @param {Vector3} target */
  at(target) {
    const { body } = this;
    target.copy(this.position);
    if (!body) return target;
    if (this.patterns) {
      const [u, amplitudes] = [[0, 0, 0], body.amplitudes];
      for (let column = 0; column < amplitudes.length; column++) {
        for (let axis = 0; axis < 3; axis++) u[axis] += amplitudes[column] * this.patterns[3 * column + axis];
      }
      target.x += body.scale * u[0];
      target.y += body.scale * u[1];
      target.z += body.scale * u[2];
    }
    return target.applyQuaternion(body.group.quaternion).add(body.group.position);
  }
}

/** Mean patterns of the nodes next to a place: three numbers a column. */
function patterns(shape, position, size) {
  const x = shape.positions;
  const distances = new Float32Array(shape.count);
  let nearest = Infinity;
  for (let node = 0; node < shape.count; node++) {
    distances[node] = Math.hypot(x[3 * node] - position[0], x[3 * node + 1] - position[1], x[3 * node + 2] - position[2]);
    nearest = Math.min(nearest, distances[node]);
  }
  const limit = TOGETHER * nearest + 1e-6 * size;
  const nodes = [];
  for (let node = 0; node < shape.count && nodes.length < MOST; node++) if (distances[node] <= limit) nodes.push(node);
  return Float32Array.from({ length: 3 * shape.columns.length }, (_, k) => {
    const [column, axis] = [shape.columns[Math.floor(k / 3)], k % 3];
    return nodes.reduce((sum, node) => sum + column[3 * node + axis], 0) / nodes.length;
  });
}
