/** A mesh with patterns of displacement, for the shader and for numbers. */
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Vector3 } from "three";

/** Cosine of the angle between two triangles from which their edge is drawn. */
const CREASE = Math.cos((25 * Math.PI) / 180);
/** Sides of the tube that is drawn for a line, and its radius over the size of everything. */
const SIDES = 8;
const RADIUS = 0.005;

export class Shape {
  constructor(description, arrays, size) {
    this.name = description.name;
    this.corners = description.corners;
    this.positions = arrays.view(description.positions);
    this.nodes = arrays.view(description.nodes);
    this.cells = arrays.view(description.cells);
    this.error = description.error;
    this.count = this.positions.length / 3;
    this.columns = description.columns.map((column) => {
      const integers = arrays.view(column.values);
      const values = new Float32Array(integers.length);
      for (let k = 0; k < values.length; k++) values[k] = integers[k] * column.scale;
      return values;
    });
    this.largest = this.columns.map((values) => {
      let largest = 0;
      for (let k = 0; k < values.length; k += 3) {
        largest = Math.max(largest, Math.hypot(values[k], values[k + 1], values[k + 2]));
      }
      return largest;
    });
    /** Node of each vertex that is drawn; lines are drawn as tubes. */
    const drawn = this.corners === 2 ? this.#tubes(RADIUS * size) : { positions: this.positions, cells: this.cells, node: null };
    this.vertexNode = drawn.node;
    this.drawnCells = drawn.cells;
    this.position = new BufferAttribute(drawn.positions, 3);
    this.edges = this.corners === 3 ? this.#creases() : new Uint32Array(0);
  }

  /** A geometry with these cells that deflects in these columns; its colours are its own. */
  geometry(cells, columns) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.position);
    geometry.setIndex(new BufferAttribute(cells, 1));
    this.deflectIn(geometry, columns);
    return geometry;
  }

  /** A geometry whose positions are its own too. */
  ownGeometry(cells) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.position.array.slice(), 3).setUsage(DynamicDrawUsage));
    geometry.setIndex(new BufferAttribute(cells, 1));
    return geometry;
  }

  /** The shader adds these columns, and no others: each costs time at every vertex. */
  deflectIn(geometry, columns) {
    if (columns.length === 0) return;
    this.morphs ??= [];
    geometry.morphAttributes.position = columns.map((column) => (this.morphs[column] ??= new BufferAttribute(this.atVertices(column), 3)));
    geometry.morphTargetsRelative = true;
  }

  /** Number of vertices that are drawn. */
  get vertexCount() {
    return this.position.count;
  }

  /** A column at the vertices that are drawn. */
  atVertices(column) {
    const values = this.columns[column];
    if (!this.vertexNode) return values;
    this.spread ??= [];
    return (this.spread[column] ??= Float32Array.from({ length: 3 * this.vertexNode.length }, (_, k) => values[3 * this.vertexNode[Math.floor(k / 3)] + (k % 3)]));
  }

  /** Lines as tubes: a ring of vertices at each end. */
  #tubes(radius) {
    const positions = [];
    const cells = [];
    const node = [];
    const x = this.positions;
    for (let c = 0; c < this.cells.length; c += 2) {
      const ends = [this.cells[c], this.cells[c + 1]];
      const [a, b] = ends.map((end) => [x[3 * end], x[3 * end + 1], x[3 * end + 2]]);
      const along = b.map((value, k) => value - a[k]);
      const length = Math.hypot(...along) || 1;
      const t = along.map((value) => value / length);
      const other = Math.abs(t[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
      const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
      const first = cross(t, other);
      const norm = Math.hypot(...first);
      const e = first.map((value) => value / norm);
      const f = cross(t, e);
      const start = node.length;
      for (const [which, end] of [a, b].entries()) {
        for (let side = 0; side < SIDES; side++) {
          const angle = (2 * Math.PI * side) / SIDES;
          for (let k = 0; k < 3; k++) positions.push(end[k] + radius * (Math.cos(angle) * e[k] + Math.sin(angle) * f[k]));
          node.push(ends[which]);
        }
      }
      for (let side = 0; side < SIDES; side++) {
        const [p, q] = [start + side, start + ((side + 1) % SIDES)];
        cells.push(p, q, q + SIDES, p, q + SIDES, p + SIDES);
      }
    }
    return { positions: Float32Array.from(positions), cells: Uint32Array.from(cells), node: Uint32Array.from(node) };
  }

  /** The nodes that are outmost in 26 directions. */
  outmost() {
    const x = this.positions;
    const found = new Set();
    for (let k = 0; k < 27; k++) {
      const [a, b, c] = [(k % 3) - 1, (Math.floor(k / 3) % 3) - 1, Math.floor(k / 9) - 1];
      if (k === 13) continue;
      let [best, largest] = [0, -Infinity];
      for (let node = 0; node < this.count; node++) {
        const value = a * x[3 * node] + b * x[3 * node + 1] + c * x[3 * node + 2];
        if (value > largest) [best, largest] = [node, value];
      }
      found.add(best);
    }
    return [...found].map((node) => new Vector3(x[3 * node], x[3 * node + 1], x[3 * node + 2]));
  }

  /** Displacements for amplitudes, body axes. */
  displacements(amplitudes, target) {
    target.fill(0);
    this.columns.forEach((values, column) => {
      const amplitude = amplitudes[column];
      if (amplitude === 0) return;
      for (let k = 0; k < values.length; k++) target[k] += amplitude * values[k];
    });
    return target;
  }

  /** Displacement of one node. */
  displacement(index, amplitudes) {
    const u = [0, 0, 0];
    this.columns.forEach((values, column) => {
      for (let axis = 0; axis < 3; axis++) u[axis] += amplitudes[column] * values[3 * index + axis];
    });
    return u;
  }

  /** Equivalent strain at the nodes of triangles: in the plane of each, averaged. */
  strains(u, target) {
    const { positions: x, cells } = this;
    target.fill(0);
    this.weights ??= weights(cells, this.count);
    for (let c = 0; c < cells.length; c += 3) {
      const strain = inTriangle(x, u, cells[c], cells[c + 1], cells[c + 2]);
      for (let k = 0; k < 3; k++) target[cells[c + k]] += strain;
    }
    for (let node = 0; node < this.count; node++) target[node] /= this.weights[node];
    return target;
  }

  /** Edges of the outline and where triangles meet at an angle. */
  #creases() {
    const normals = new Map();
    const { positions: x, cells } = this;
    const of = (c) => {
      const [a, b, d] = [3 * cells[c], 3 * cells[c + 1], 3 * cells[c + 2]];
      const e = [0, 1, 2].map((k) => x[b + k] - x[a + k]);
      const f = [0, 1, 2].map((k) => x[d + k] - x[a + k]);
      const n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
      const length = Math.hypot(...n) || 1;
      return n.map((value) => value / length);
    };
    for (let c = 0; c < cells.length; c += 3) {
      const normal = of(c);
      for (let k = 0; k < 3; k++) {
        const [a, b] = [cells[c + k], cells[c + ((k + 1) % 3)]];
        const key = a < b ? a * this.count + b : b * this.count + a;
        const known = normals.get(key);
        if (!known) normals.set(key, [normal, true]);
        else known[1] = Math.abs(known[0][0] * normal[0] + known[0][1] * normal[1] + known[0][2] * normal[2]) < CREASE;
      }
    }
    const edges = [];
    for (const [key, [, drawn]] of normals) {
      if (drawn) edges.push(Math.floor(key / this.count), key % this.count);
    }
    return Uint32Array.from(edges);
  }
}

/** Number of the cells at each node, at least 1. */
function weights(cells, count) {
  const number = new Float32Array(count);
  for (const node of cells) number[node] += 1;
  return number.map((value) => Math.max(value, 1));
}

/** Equivalent (von Mises) strain of a plane state from a constant displacement gradient in a triangle. */
function inTriangle(x, u, a, b, c) {
  const [p, q, r] = [3 * a, 3 * b, 3 * c];
  const [ex, ey, ez] = [x[q] - x[p], x[q + 1] - x[p + 1], x[q + 2] - x[p + 2]];
  const [fx, fy, fz] = [x[r] - x[p], x[r + 1] - x[p + 1], x[r + 2] - x[p + 2]];
  const length = Math.sqrt(ex * ex + ey * ey + ez * ez);
  if (length === 0) return 0;
  const [ax, ay, az] = [ex / length, ey / length, ez / length];
  const along = fx * ax + fy * ay + fz * az;
  const [gx, gy, gz] = [fx - along * ax, fy - along * ay, fz - along * az];
  const height = Math.sqrt(gx * gx + gy * gy + gz * gz);
  if (height < 1e-12 * length) return 0;
  const [bx, by, bz] = [gx / height, gy / height, gz / height];
  const [dx, dy, dz] = [u[q] - u[p], u[q + 1] - u[p + 1], u[q + 2] - u[p + 2]];
  const [hx, hy, hz] = [u[r] - u[p], u[r + 1] - u[p + 1], u[r + 2] - u[p + 2]];
  const xx = (dx * ax + dy * ay + dz * az) / length;
  const xy = (hx * ax + hy * ay + hz * az - along * xx) / height;
  const yx = (dx * bx + dy * by + dz * bz) / length;
  const yy = (hx * bx + hy * by + hz * bz - along * yx) / height;
  const shear = xy + yx;
  // Plane strain components without the one across the surface: sqrt(xx² + yy² - xx yy + 3/4 shear²).
  return Math.sqrt(Math.max(0, xx * xx + yy * yy - xx * yy + 0.75 * shear * shear));
}
