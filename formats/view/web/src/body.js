/** A body in the view: its mesh or its solids, moved, deflected and coloured. */
import {
  Box3, BufferAttribute, DoubleSide, Group, Mesh, MeshLambertMaterial, Points, PointsMaterial,
} from "three";
import { BODY_COLOURS, paint } from "./colours.js";
import { Motion, Quaternion, Vector3, largestAmplitudes } from "./motion.js";
import { solid } from "./solids.js";

/** Columns that never reach this part of the body's largest deflection aren't drawn: each costs time at every vertex. */
const INVISIBLE = 1e-3;

export class Body {
  /** @param {"shader" | "processor"} where who adds the deflection to the surface */
  constructor(description, index, shapes, times, arrays, size, where) {
    this.where = where;
    this.name = description.name;
    this.points = description.points ?? [];
    this.shape = description.shape == null ? null : shapes[description.shape];
    const view = (place) => (place ? arrays.view(place) : null);
    const columns = this.shape?.columns.length ?? 0;
    this.motion = new Motion(times, view(description.frames), description.rest, view(description.amplitudes), columns);
    this.amplitudes = new Float64Array(columns);
    /** Columns that are drawn: those of a motion, or the one mode that is shown. */
    this.columns = this.motion.amplitudes ? this.#seen() : columns > 0 ? [0] : [];
    /** How much larger than it is its deflection is drawn. */
    this.scale = 1;
    this.group = new Group();
    this.surface = null;
    const colour = BODY_COLOURS[index % BODY_COLOURS.length];
    this.material = new MeshLambertMaterial({ color: colour, flatShading: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    this.colour = this.material.color.clone();
    if (this.shape) this.#mesh(colour);
    const solids = (description.solids ?? (description.solid ? [description.solid] : [])).map((one) => solid(one, arrays, this.material, size));
    this.around = this.#outlinePoints(solids);
    if (solids.length > 0) this.group.add(...solids);
    this.group.traverse((object) => (object.userData.body = this));
  }

  #mesh(colour) {
    const { shape } = this;
    const geometry = this.where === "shader" ? shape.geometry(shape.drawnCells, this.columns) : shape.ownGeometry(shape.drawnCells);
    if (shape.corners >= 2) this.surface = new Mesh(geometry, this.material);
    else this.surface = new Points(geometry, new PointsMaterial({ color: colour, size: 4, sizeAttenuation: false }));
    this.surface.frustumCulled = false;
    this.group.add(this.surface);
  }

  /** Points that stand for what it takes up, body axes. */
  outlinePoints() {
    return this.around;
  }

  /** The mesh by its nodes at rest: the box of its geometry counts each column in full. */
  #outlinePoints(solids) {
    const points = this.points.map((point) => new Vector3(...point.position));
    if (solids.length > 0) {
      const box = new Box3();
      for (const one of solids) box.expandByObject(one);
      for (let k = 0; k < 8; k++) points.push(new Vector3(...["x", "y", "z"].map((axis, place) => ((k >> place) & 1 ? box.max : box.min)[axis])));
    }
    if (this.shape) points.push(...this.shape.outmost());
    return points.length > 0 ? points : [new Vector3()];
  }

  /** Columns that are seen in the motion. */
  #seen() {
    const largest = largestAmplitudes(this.motion);
    const reaches = this.shape.largest.map((length, column) => length * largest[column]);
    const limit = INVISIBLE * Math.max(0, ...reaches);
    return [...reaches.keys()].filter((column) => reaches[column] > limit);
  }

  /** Largest deflection over the motion, an estimate from above. */
  reach() {
    if (!this.shape) return 0;
    const largest = largestAmplitudes(this.motion);
    return this.shape.largest.reduce((sum, length, column) => Math.max(sum, length * largest[column]), 0);
  }

  /** Moves it to a time, its deflection enlarged. */
  show(time, scale) {
    this.motion.pose(time, this.group.position, this.group.quaternion);
    this.deflect(this.motion.amplitude(time, this.amplitudes), scale);
  }

  /** Deflects it. */
  deflect(amplitudes, scale) {
    this.scale = scale;
    if (!this.surface || this.columns.length === 0) return;
    const factors = this.columns.map((column) => amplitudes[column] * scale);
    if (this.where === "shader") factors.forEach((factor, k) => (this.surface.morphTargetInfluences[k] = factor));
    else this.#place(factors);
  }

  /** Moves the vertices here: a renderer without a graphics card takes ten times as long for it. */
  #place(factors) {
    if (this.placed && factors.every((factor, k) => factor === this.placed[k])) return;
    this.placed = factors;
    const attribute = this.surface.geometry.getAttribute("position");
    const target = attribute.array;
    target.set(this.shape.position.array);
    factors.forEach((factor, k) => {
      const values = this.shape.atVertices(this.columns[k]);
      for (let at = 0; at < target.length; at++) target[at] += factor * values[at];
    });
    attribute.needsUpdate = true;
    this.surface.geometry.boundingSphere = null;
  }

  /** Deflects in one column from now on. */
  deflectIn(column) {
    if (this.columns.length === 1 && this.columns[0] === column) return;
    this.columns = [column];
    this.placed = null;
    if (this.where === "processor") return;
    this.surface.geometry.dispose();
    this.shape.deflectIn(this.surface.geometry, this.columns);
    this.surface.updateMorphTargets();
  }

  /** The value at each node that colours show. */
  values(what, time) {
    const { shape } = this;
    if (what === "strain" && shape.corners !== 3) return null;
    this.field ??= new Float32Array(shape.count);
    this.moved ??= new Float32Array(3 * shape.count);
    const u = shape.displacements(this.amplitudes, this.moved);
    if (what === "strain") return shape.strains(u, this.field);
    if (what === "speed") return this.#speeds(time);
    for (let k = 0; k < shape.count; k++) this.field[k] = Math.hypot(u[3 * k], u[3 * k + 1], u[3 * k + 2]);
    return this.field;
  }

  #speeds(time) {
    const { times } = this.motion;
    const step = times.length > 1 ? (0.25 * (times.at(-1) - times[0])) / (times.length - 1) : 1;
    const [before, after] = [Math.max(times[0] ?? 0, time - step), Math.min(times.at(-1) ?? 0, time + step)];
    this.first ??= new Float32Array(3 * this.shape.count);
    this.second ??= new Float32Array(3 * this.shape.count);
    const [a, b] = [this.places(before, this.first), this.places(after, this.second)];
    const inverse = after > before ? 1 / (after - before) : 0;
    for (let k = 0; k < this.shape.count; k++) {
      const at = 3 * k;
      this.field[k] = inverse * Math.hypot(b[at] - a[at], b[at + 1] - a[at + 1], b[at + 2] - a[at + 2]);
    }
    return this.field;
  }

  /** Places of all nodes in the world at a time. */
  places(time, target) {
    const [origin, turn, place] = [new Vector3(), new Quaternion(), new Vector3()];
    this.motion.pose(time, origin, turn);
    const u = this.shape.displacements(this.motion.amplitude(time, new Float64Array(this.amplitudes.length)), target);
    const x = this.shape.positions;
    for (let at = 0; at < u.length; at += 3) {
      place.set(x[at] + u[at], x[at + 1] + u[at + 1], x[at + 2] + u[at + 2]).applyQuaternion(turn).add(origin);
      place.toArray(u, at);
    }
    return u;
  }

  /** Colours its nodes by values, or gives it its own colour back. */
  colourBy(values, largest) {
    const { surface } = this;
    if (!surface) return;
    const { material, geometry } = surface;
    if (!values) {
      if (material.vertexColors) {
        material.vertexColors = false;
        material.color.copy(this.colour);
        material.needsUpdate = true;
      }
      return;
    }
    let attribute = geometry.getAttribute("color");
    if (!attribute) {
      attribute = new BufferAttribute(new Float32Array(3 * this.shape.vertexCount), 3);
      geometry.setAttribute("color", attribute);
    }
    const { vertexNode, vertexCount } = this.shape;
    for (let k = 0; k < vertexCount; k++) paint(largest > 0 ? values[vertexNode ? vertexNode[k] : k] / largest : 0, attribute.array, 3 * k);
    attribute.needsUpdate = true;
    if (!material.vertexColors) {
      material.vertexColors = true;
      material.color.set(0xffffff);
      material.needsUpdate = true;
    }
  }

  /** Marks it as picked. */
  mark(isMarked) {
    this.material.emissive.set(isMarked ? 0x40380c : 0x000000);
  }
}
