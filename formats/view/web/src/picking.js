/** Picks bodies, nodes and signs with the pointer, or by name and number, and marks them. */
import { Mesh, MeshBasicMaterial, SphereGeometry } from "three";
import { number } from "./elements.js";

/** Pixels that a pointer may move in a click. */
const STILL = 4;

export class Picking {
  /** @param viewer what is picked from @param {HTMLElement} tip shows the name under the pointer */
  constructor(viewer, canvas, tip) {
    this.viewer = viewer;
    this.body = null;
    this.node = null;
    this.marker = new Mesh(new SphereGeometry(1, 12, 8), new MeshBasicMaterial({ color: 0xff2fa0, depthTest: false, transparent: true }));
    this.marker.renderOrder = 1;
    this.marker.visible = false;
    const under = (event) => viewer.glyphs.under(event.offsetX, event.offsetY, viewer.stage.camera, canvas);
    let from = null;
    canvas.addEventListener("pointerdown", (event) => (from = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (!from || Math.hypot(event.clientX - from[0], event.clientY - from[1]) >= STILL) return;
      const sign = under(event);
      if (sign) return viewer.controls.tell(sign);
      const found = viewer.stage.pick(event, viewer.bodies);
      if (found) this.pick(found.body, this.#nearest(found.body, found.hit));
      else this.pick(null, null);
    });
    canvas.addEventListener("pointermove", (event) => {
      const text = event.buttons === 0 ? under(event) : null;
      tip.hidden = !text;
      if (!text) return;
      tip.textContent = text;
      const isRight = event.offsetX > 0.6 * canvas.clientWidth;
      tip.style.left = isRight ? "" : `${event.offsetX + 14}px`;
      tip.style.right = isRight ? `${canvas.clientWidth - event.offsetX + 10}px` : "";
      tip.style.top = `${Math.max(event.offsetY - 10, 0)}px`;
    });
    canvas.addEventListener("pointerleave", () => (tip.hidden = true));
  }

  /** Place of the node next to what was hit, or null. */
  #nearest(body, hit) {
    if (!body.shape || hit.object !== body.surface) return null;
    const { position } = body.shape;
    const local = body.group.worldToLocal(hit.point.clone());
    const vertices = hit.face ? [hit.face.a, hit.face.b, hit.face.c] : [hit.index];
    const distance = (vertex) => Math.hypot(position.getX(vertex) - local.x, position.getY(vertex) - local.y, position.getZ(vertex) - local.z);
    const vertex = vertices.reduce((best, one) => (distance(one) < distance(best) ? one : best));
    return body.shape.vertexNode?.[vertex] ?? vertex;
  }

  /** @param body or null @param {number | null} node its place in the body's shape */
  pick(body, node) {
    const { viewer } = this;
    this.body = body;
    this.node = node;
    for (const one of viewer.bodies) one.mark(one === body);
    viewer.needsDraw = true;
    viewer.controls.showPicked(viewer.bodies.indexOf(body), body && node != null ? body.shape.nodes[node] : "");
    if (!body) return viewer.controls.tell("");
    const length = viewer.description.units.length;
    if (node == null) {
      const at = body.group.position.toArray().map(number).join(", ");
      viewer.controls.tell(`${body.name}: origin at ${at} ${length}`);
    } else {
      const x = body.shape.positions;
      const place = [0, 1, 2].map((k) => number(x[3 * node + k])).join(", ");
      const deflection = viewer.isPart ? "" : `, deflection ${number(Math.hypot(...body.shape.displacement(node, body.amplitudes)))} ${length}`;
      viewer.controls.tell(`${body.name}, node ${body.shape.nodes[node]} at ${place} ${length} from the origin of its frame${deflection}`);
    }
    if (!viewer.isPart) viewer.onPick?.(body, node);
  }

  /** Picks a node by its number in the mesh. */
  pickNumber(wanted) {
    const body = this.body?.shape ? this.body : this.viewer.bodies.find((one) => one.shape);
    if (!body || wanted === "") return this.pick(this.body, null);
    const { nodes } = body.shape;
    const node = nodes.indexOf(Number(wanted));
    if (node >= 0) return this.pick(body, node);
    const [low, high] = [nodes.reduce((a, b) => Math.min(a, b)), nodes.reduce((a, b) => Math.max(a, b))];
    this.viewer.controls.tell(`${body.name} has no node ${wanted} in its surface; its numbers go from ${low} to ${high}`);
  }

  /** The mark follows its node. */
  show(camera) {
    const { body, node, marker } = this;
    marker.visible = body != null && node != null;
    if (!marker.visible) return;
    const u = body.shape.displacement(node, body.amplitudes);
    const x = body.shape.positions;
    marker.position.set(...[0, 1, 2].map((k) => x[3 * node + k] + body.scale * u[k])).applyQuaternion(body.group.quaternion).add(body.group.position);
    marker.scale.setScalar(0.006 * marker.position.distanceTo(camera.position));
  }
}
