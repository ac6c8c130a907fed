/** Rigid bodies as simple geometry. */
import { BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, Group, Mesh, Quaternion, SphereGeometry, Vector3 } from "three";

const UP = new Vector3(0, 1, 0);

/** A rod between two points. */
export function rod(from, to, radius, material) {
  const [a, b] = [new Vector3(...from), new Vector3(...to)];
  const axis = b.clone().sub(a);
  const length = axis.length();
  if (length === 0) return new Group();
  const mesh = new Mesh(new CylinderGeometry(radius, radius, length, 20), material);
  mesh.position.copy(a).add(b).multiplyScalar(0.5);
  mesh.quaternion.setFromUnitVectors(UP, axis.divideScalar(length));
  return mesh;
}

function placed(mesh, { position, turn }) {
  if (position) mesh.position.set(...position);
  if (turn) mesh.quaternion.copy(new Quaternion(turn[1], turn[2], turn[3], turn[0]));
  return mesh;
}

/** One solid of the description. */
export function solid(one, arrays, bodyMaterial, size) {
  const group = new Group();
  const material = one.color ? bodyMaterial.clone() : bodyMaterial;
  if (one.color) material.color.set(one.color);
  switch (one.kind) {
    case "box":
      group.add(placed(new Mesh(new BoxGeometry(...one.sides), material), one));
      break;
    case "cylinder": {
      const geometry = new CylinderGeometry(one.radius, one.radius, one.length, 48).rotateX(Math.PI / 2);
      group.add(placed(new Mesh(geometry, material), one));
      break;
    }
    case "sphere": {
      const radius = one.radius > 0 ? one.radius : 0.02 * size;
      group.add(placed(new Mesh(new SphereGeometry(radius, 24, 16), material), one));
      break;
    }
    case "stick":
      for (const end of one.ends.slice(1)) group.add(rod(one.ends[0], end, one.radius, material));
      for (const end of one.ends) {
        const ball = new Mesh(new SphereGeometry(1.25 * one.radius, 16, 12), material);
        ball.position.set(...end);
        group.add(ball);
      }
      break;
    case "mesh": {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(arrays.view(one.positions), 3));
      geometry.setIndex(new BufferAttribute(arrays.view(one.cells), 1));
      group.add(placed(new Mesh(geometry, material), one));
      break;
    }
  }
  return group;
}
