/** Joints, interfaces and loads as small signs. */
import {
  ArrowHelper, BoxGeometry, CylinderGeometry, Group, Mesh, MeshStandardMaterial, Quaternion, SphereGeometry, TorusGeometry, Vector3,
} from "three";

const Y = new Vector3(0, 1, 0);
const Z = new Vector3(0, 0, 1);

export class Glyphs {
  constructor(description, bodies, arrays, size) {
    this.length = 0.018 * size;
    this.group = new Group();
    this.moving = [];
    this.loads = [];
    const steel = new MeshStandardMaterial({ color: 0xd9a21b, roughness: 0.5 });
    const blue = new MeshStandardMaterial({ color: 0x2f7fd1, roughness: 0.5 });
    const isPlanar = description.dimension === 2;
    for (const joint of description.joints ?? []) {
      this.#hang(bodies, joint.a, this.#joint(joint, steel, isPlanar));
    }
    for (const body of bodies) {
      for (const point of body.points) {
        const dot = new Mesh(new SphereGeometry(0.35 * this.length, 12, 8), blue);
        this.#hang(bodies, { body: bodies.indexOf(body), position: point.position }, dot);
      }
    }
    for (const load of description.loads ?? []) {
      const arrow = new ArrowHelper(Y, new Vector3(), 1, load.moment ? 0x9b3fb5 : 0xcc2f2f);
      const components = arrays.view(load.components);
      let largest = 0;
      for (let k = 0; k < components.length; k += 3) largest = Math.max(largest, Math.hypot(components[k], components[k + 1], components[k + 2]));
      this.loads.push({ load, arrow, components, largest });
      this.group.add(arrow);
    }
  }

  #joint(joint, material, isPlanar) {
    const r = this.length;
    const axis = joint.a.axis ? new Vector3(...joint.a.axis).normalize() : Z.clone();
    const turned = (mesh, from) => {
      mesh.quaternion.setFromUnitVectors(from, axis);
      return mesh;
    };
    switch (joint.kind) {
      case "revolute":
        return turned(new Mesh(new CylinderGeometry(0.8 * r, 0.8 * r, isPlanar ? 0.8 * r : 2.4 * r, 20), material), Y);
      case "cylindrical":
        return turned(new Mesh(new CylinderGeometry(0.6 * r, 0.6 * r, 4 * r, 20), material), Y);
      case "prismatic":
        return turned(new Mesh(new BoxGeometry(3.4 * r, 1.5 * r, 1.5 * r), material), new Vector3(1, 0, 0));
      case "universal":
        return turned(new Mesh(new TorusGeometry(0.9 * r, 0.25 * r, 10, 24), material), Z);
      case "spherical":
        return new Mesh(new SphereGeometry(r, 20, 14), material);
      default:
        return new Mesh(new BoxGeometry(1.1 * r, 1.1 * r, 1.1 * r), material);
    }
  }

  #hang(bodies, end, glyph) {
    const turn = glyph.quaternion.clone();
    this.moving.push({ body: end.body == null ? null : bodies[end.body], position: new Vector3(...end.position), turn, glyph });
    this.group.add(glyph);
  }

  /** Follows the bodies. `loads` are shown at the share of the way between two times. */
  show(bodies, [first, share]) {
    for (const { body, position, turn, glyph } of this.moving) {
      glyph.position.copy(position);
      glyph.quaternion.copy(turn);
      if (!body) continue;
      glyph.position.applyQuaternion(body.group.quaternion).add(body.group.position);
      glyph.quaternion.premultiply(body.group.quaternion);
    }
    for (const { load, arrow, components, largest } of this.loads) {
      const value = (k) => {
        const next = Math.min(3 * first + 3 + k, components.length - 3 + k);
        return components[3 * first + k] * (1 - share) + components[next] * share;
      };
      const force = new Vector3(value(0), value(1), value(2));
      const magnitude = force.length();
      arrow.visible = largest > 0 && magnitude > 1e-3 * largest;
      if (!arrow.visible) continue;
      const body = load.body == null ? null : bodies[load.body];
      const turn = body?.group.quaternion ?? new Quaternion();
      if (!load.world) force.applyQuaternion(turn);
      const length = Math.max(9 * this.length * (magnitude / largest), 1.5 * this.length);
      const tip = new Vector3(...load.position);
      if (body) tip.applyQuaternion(turn).add(body.group.position);
      const direction = force.divideScalar(magnitude);
      arrow.position.copy(tip).addScaledVector(direction, -length);
      arrow.setDirection(direction);
      arrow.setLength(length, Math.min(0.3 * length, 1.6 * this.length), Math.min(0.15 * length, 0.8 * this.length));
    }
  }
}
