/** Joints, interfaces and loads as small signs, with names. */
import {
  ArrowHelper, BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, Group, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4,
  MeshLambertMaterial, Quaternion, SphereGeometry, TorusGeometry, Vector3,
} from "three";
import { Follower } from "./follower.js";

const Y = new Vector3(0, 1, 0);
const Z = new Vector3(0, 0, 1);
const ONE = new Vector3(1, 1, 1);
/** Pixels around the pointer in which a sign is found. */
const NEAR = 11;
/** Names that are shown of signs in one place, at most. */
const NAMES = 4;

export class Glyphs {
  constructor(description, bodies, arrays, size) {
    this.length = 0.015 * size;
    this.size = size;
    this.group = new Group();
    /** All signs: `{text, place}`, the place of now in the world. */
    this.signs = [];
    this.kinds = [];
    this.loads = [];
    const body = (index) => (index == null ? null : bodies[index]);
    const name = (index) => (index == null ? "ground" : bodies[index].name);
    const joints = description.joints ?? [];
    for (const kind of new Set(joints.map((joint) => joint.kind))) {
      const members = joints.filter((joint) => joint.kind === kind).map((joint) => {
        const isSliding = kind === "prismatic" || kind === "cylindrical";
        const axis = joint.a.axis ? new Vector3(...joint.a.axis).normalize() : Z;
        const ends = [joint.a, joint.b].map((end) => new Follower(body(end.body), end.position, size));
        return {
          text: `${kind} joint ${joint.name} between ${name(joint.a.body)} and ${name(joint.b.body)}`,
          place: new Vector3(), holder: body(joint.a.body), ends, isSliding, shown: ends[isSliding ? 1 : 0],
          turn: new Quaternion().setFromUnitVectors(along(kind), axis),
        };
      });
      this.#kind(members, shape(kind, this.length, description.dimension === 2), 0xd9a21b);
    }
    const points = bodies.flatMap((one) => one.points.map((point) => ({
      text: `${point.name}, ${one.shape ? "interface" : "point"} of ${one.name}`, place: new Vector3(), holder: one, shown: new Follower(one, point.position, size), turn: new Quaternion(),
    })));
    this.#kind(points, new SphereGeometry(0.35 * this.length, 10, 6), 0x2f7fd1);
    this.#links(this.kinds.flatMap(({ members }) => members.filter((member) => member.ends && !member.isSliding)));
    for (const load of description.loads ?? []) {
      const arrow = new ArrowHelper(Y, new Vector3(), 1, load.moment ? 0x9b3fb5 : 0xcc2f2f);
      const components = arrays.view(load.components);
      let largest = 0;
      for (let k = 0; k < components.length; k += 3) largest = Math.max(largest, Math.hypot(components[k], components[k + 1], components[k + 2]));
      const sign = { text: `${load.moment ? "moment" : "force"} ${load.name} on ${name(load.body)}`, place: new Vector3() };
      this.signs.push(sign);
      this.loads.push({ load, arrow, components, largest, sign, body: body(load.body), follower: new Follower(body(load.body), load.position, size) });
      this.group.add(arrow);
    }
  }

  /** All signs of a kind in one go: each further drawing costs time. */
  #kind(members, geometry, color) {
    if (members.length === 0) return;
    const mesh = new InstancedMesh(geometry, new MeshLambertMaterial({ color }), members.length);
    mesh.frustumCulled = false;
    this.kinds.push({ mesh, members });
    this.signs.push(...members);
    this.group.add(mesh);
  }

  /** Lines between the two ends of a joint: an enlarged deflection draws them apart. */
  #links(members) {
    this.linked = members;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(6 * members.length), 3));
    this.links = new LineSegments(geometry, new LineBasicMaterial({ color: 0xd9a21b }));
    this.links.frustumCulled = false;
    this.group.add(this.links);
  }

  /** Follows the bodies. `loads` are shown at the share of the way between two times. */
  show([first, share]) {
    const [matrix, turn, end] = [new Matrix4(), new Quaternion(), new Vector3()];
    for (const { mesh, members } of this.kinds) {
      members.forEach((member, k) => {
        member.shown.at(member.place);
        turn.copy(member.turn);
        if (member.holder) turn.premultiply(member.holder.group.quaternion);
        mesh.setMatrixAt(k, matrix.compose(member.place, turn, ONE));
      });
      mesh.instanceMatrix.needsUpdate = true;
    }
    let apart = 0;
    const lines = this.links.geometry.getAttribute("position");
    for (const { place, ends } of this.linked) {
      ends[1].at(end);
      if (end.distanceTo(place) < 0.5 * this.length) continue;
      place.toArray(lines.array, 6 * apart);
      end.toArray(lines.array, 6 * apart + 3);
      apart += 1;
    }
    this.links.visible = apart > 0;
    this.links.geometry.setDrawRange(0, 2 * apart);
    lines.needsUpdate = apart > 0;
    for (const one of this.loads) this.#arrow(one, first, share);
  }

  #arrow({ load, arrow, components, largest, sign, body, follower }, first, share) {
    const value = (k) => {
      const next = Math.min(3 * first + 3 + k, components.length - 3 + k);
      return components[3 * first + k] * (1 - share) + components[next] * share;
    };
    const force = new Vector3(value(0), value(1), value(2));
    const magnitude = force.length();
    arrow.visible = largest > 0 && magnitude > 1e-3 * largest;
    follower.at(sign.place);
    if (!arrow.visible) return;
    if (!load.world && body) force.applyQuaternion(body.group.quaternion);
    const length = Math.max(9 * this.length * (magnitude / largest), 1.5 * this.length);
    const direction = force.divideScalar(magnitude);
    arrow.position.copy(sign.place).addScaledVector(direction, -length);
    arrow.setDirection(direction);
    arrow.setLength(length, Math.min(0.3 * length, 1.6 * this.length), Math.min(0.15 * length, 0.8 * this.length));
    sign.place.copy(arrow.position).addScaledVector(direction, 0.7 * length);
  }

  /** The names of what is under a place of the canvas, or null. */
  under(left, top, camera, { clientWidth, clientHeight }) {
    if (!this.group.visible) return null;
    const at = new Vector3();
    const found = this.signs.filter((sign) => {
      at.copy(sign.place).project(camera);
      return at.z < 1 && Math.hypot(0.5 * (at.x + 1) * clientWidth - left, 0.5 * (1 - at.y) * clientHeight - top) < NEAR;
    });
    if (found.length === 0) return null;
    const texts = found.slice(0, NAMES).map((sign) => sign.text);
    return texts.join("; ") + (found.length > NAMES ? `; ${found.length - NAMES} more` : "");
  }
}

/** The axis of a joint's sign before it is turned. */
function along(kind) {
  if (kind === "prismatic") return new Vector3(1, 0, 0);
  return kind === "revolute" || kind === "cylindrical" ? Y : Z;
}

function shape(kind, r, isPlanar) {
  switch (kind) {
    case "revolute":
      return new CylinderGeometry(0.8 * r, 0.8 * r, isPlanar ? 0.8 * r : 2.4 * r, 16);
    case "cylindrical":
      return new CylinderGeometry(0.6 * r, 0.6 * r, 4 * r, 16);
    case "prismatic":
      return new BoxGeometry(3.4 * r, 1.5 * r, 1.5 * r);
    case "universal":
      return new TorusGeometry(0.9 * r, 0.25 * r, 8, 20);
    case "spherical":
      return new SphereGeometry(r, 16, 12);
    default:
      return new BoxGeometry(1.1 * r, 1.1 * r, 1.1 * r);
  }
}
