/** The edges of all meshes in one drawing: a drawing for each body costs more than moving their few nodes here. */
import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Matrix4 } from "three";

export class Outlines {
  constructor(bodies) {
    this.members = bodies.filter((body) => body.shape?.edges.length > 0).map((body) => ({ body, ...used(body.shape) }));
    const count = this.members.reduce((sum, { nodes }) => sum + nodes.length, 0);
    const index = [];
    let first = 0;
    for (const { nodes, ends } of this.members) {
      for (const end of ends) index.push(first + end);
      first += nodes.length;
    }
    const geometry = new BufferGeometry();
    this.position = new BufferAttribute(new Float32Array(3 * count), 3);
    geometry.setAttribute("position", this.position);
    geometry.setIndex(new BufferAttribute(Uint32Array.from(index), 1));
    this.lines = new LineSegments(geometry, new LineBasicMaterial({ color: 0x101418, transparent: true, opacity: 0.55 }));
    this.lines.frustumCulled = false;
    this.matrix = new Matrix4();
  }

  /** Follows the bodies. */
  show() {
    const target = this.position.array;
    let at = 0;
    for (const { body, nodes } of this.members) {
      const { shape, amplitudes, columns, scale, group } = body;
      const m = this.matrix.makeRotationFromQuaternion(group.quaternion).setPosition(group.position).elements;
      const rest = shape.positions;
      for (const node of nodes) {
        const k = 3 * node;
        let [x, y, z] = [rest[k], rest[k + 1], rest[k + 2]];
        for (const column of columns) {
          const amplitude = scale * amplitudes[column];
          const values = shape.columns[column];
          x += amplitude * values[k];
          y += amplitude * values[k + 1];
          z += amplitude * values[k + 2];
        }
        target[at++] = m[0] * x + m[4] * y + m[8] * z + m[12];
        target[at++] = m[1] * x + m[5] * y + m[9] * z + m[13];
        target[at++] = m[2] * x + m[6] * y + m[10] * z + m[14];
      }
    }
    this.position.needsUpdate = true;
  }
}

/** Nodes that edges use, and the edges' ends as places among them. */
function used({ edges }) {
  const nodes = [...new Set(edges)];
  const places = new Map(nodes.map((node, place) => [node, place]));
  return { nodes, ends: Array.from(edges, (node) => places.get(node)) };
}
