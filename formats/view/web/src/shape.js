/** A mesh with patterns of displacement, for the shader and for numbers. */
import { BufferAttribute, BufferGeometry } from "three";

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

  /** The shader adds these columns, and no others: each costs time at every vertex. */
  deflectIn(geometry, columns) {
    if (columns.length === 0) return;
    this.morphs ??= [];
    geometry.morphAttributes.position = columns.map((column) => (this.morphs[column] ??= new BufferAttribute(this.#atVertices(this.columns[column]), 3)));
    geometry.morphTargetsRelative = true;
  }

  /** Number of vertices that are drawn. */
  get vertexCount() {
    return this.position.count;
  }

  #atVertices(values) {
    if (!this.vertexNode) return values;
    const spread = new Float32Array(3 * this.vertexNode.length);
    this.vertexNode.forEach((node, vertex) => {
      for (let axis = 0; axis < 3; axis++) spread[3 * vertex + axis] = values[3 * node + axis];
    });
    return spread;
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

  /** Lowest and highest coordinates. */
  box() {
    const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    this.positions.forEach((value, k) => {
      box[0][k % 3] = Math.min(box[0][k % 3], value);
      box[1][k % 3] = Math.max(box[1][k % 3], value);
    });
    return box;
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

  /** Equivalent strain at the nodes: in the plane of each surface triangle, or along a line, averaged. */
  strains(u, target) {
    const { positions: x, cells, corners } = this;
    target.fill(0);
    if (corners === 1) return target;
    const weights = new Float32Array(this.count);
    for (let c = 0; c < cells.length; c += corners) {
      const nodes = cells.subarray(c, c + corners);
      const strain = corners === 3 ? inTriangle(x, u, nodes) : alongLine(x, u, nodes);
      for (const node of nodes) {
        target[node] += strain;
        weights[node] += 1;
      }
    }
    for (let node = 0; node < this.count; node++) target[node] /= Math.max(weights[node], 1);
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

/** Equivalent (von Mises) strain of a plane state from a constant displacement gradient in a triangle. */
function inTriangle(x, u, [a, b, c]) {
  const at = (values, node, k) => values[3 * node + k];
  const edge = (values, from, to) => [0, 1, 2].map((k) => at(values, to, k) - at(values, from, k));
  const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const e = edge(x, a, b);
  const f = edge(x, a, c);
  const length = Math.sqrt(dot(e, e));
  if (length === 0) return 0;
  const first = e.map((value) => value / length);
  const along = dot(f, first);
  const across = f.map((value, k) => value - along * first[k]);
  const height = Math.sqrt(dot(across, across));
  if (height < 1e-12 * length) return 0;
  const second = across.map((value) => value / height);
  const du = edge(u, a, b);
  const dv = edge(u, a, c);
  const gradient = (direction) => {
    const byFirst = dot(du, direction) / length;
    return [byFirst, (dot(dv, direction) - along * byFirst) / height];
  };
  const [xx, xy] = gradient(first);
  const [yx, yy] = gradient(second);
  const shear = xy + yx;
  // Plane strain components without the one across the surface: sqrt(xx² + yy² - xx yy + 3/4 shear²).
  return Math.sqrt(Math.max(0, xx * xx + yy * yy - xx * yy + 0.75 * shear * shear));
}

function alongLine(x, u, [a, b]) {
  let length = 0;
  let change = 0;
  for (let k = 0; k < 3; k++) {
    const edge = x[3 * b + k] - x[3 * a + k];
    length += edge * edge;
    change += edge * (u[3 * b + k] - u[3 * a + k]);
  }
  return length > 0 ? Math.abs(change) / length : 0;
}
