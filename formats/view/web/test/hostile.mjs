/**
 * A part and a scene with names that try to leave their places in a page, and long ones.
 *   node test/hostile.mjs BEAM.json PART.json SCENE.json      BEAM.json: of the sample `beam`; the scene's part is beside it, as PART.dcb.h5
 */
import { readFile, writeFile } from "node:fs/promises";
import { basename } from "node:path";

const [beam, part, scene] = process.argv.slice(2);
const escape = "</script><script>alert(1)</script><!--<img src=x onerror=alert(2)>\"'&<b>";
// A slash parts a body from its interface.
const tag = escape.replaceAll("/", "");
const long = `${"x".repeat(300)}é漢字🙂`;

const mesh = JSON.parse(await readFile(beam, "utf8"));
mesh.component.name = `part ${escape}`;
mesh.component.interfaces[0].name = `tip${tag}`;
mesh.component.interfaces[1].name = long;
await writeFile(part, JSON.stringify(mesh));
const ball = `ball${tag}`;
await writeFile(scene, JSON.stringify({
  dimension: 3,
  units: { length: "m", mass: "kg", time: "s" },
  gravity: [0, 0, -9.81],
  bodies: {
    [tag]: { superelement: basename(part).replace(/\.json$/, ".dcb.h5") },
    [ball]: { rigid: { mass: 1, inertia: [0.1, 0.1, 0.1], points: { [`p${tag}`]: [0, 0, 0] } }, position: [3, 0, 0] },
  },
  joints: { [`joint${tag}`]: { fixed: { a: "ground", b: `${tag}/tip${tag}` } } },
  loads: { [`load${tag}`]: { force: { at: `${ball}/p${tag}`, components: [0, 0, { formula: "5*sin(20*t)" }] } } },
  outputs: { [`output${tag}`]: { position: { at: `${tag}/${long}` } } },
  integrator: { generalized_alpha: { step: 1e-3, end: 0.1 } },
}));
