/** Camera, light, ground and axes. */
import {
  AxesHelper, Color, DirectionalLight, GridHelper, HemisphereLight, PerspectiveCamera, Quaternion, Raycaster, Scene, TOUCH, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { fit } from "./fit.js";

/** Directions from which the standard views look, in axes where z is up. */
const VIEWS = { front: [0, -1, 0], back: [0, 1, 0], left: [-1, 0, 0], right: [1, 0, 0], top: [0, -0.001, 1], bottom: [0, -0.001, -1], home: [0.62, -0.85, 0.5] };

/** Milliseconds a picture may take while it moves, and the coarsest pixels that are drawn then. */
const SLOW = 30;
const COARSEST = 0.5;

/** Whether there is no graphics card: smooth edges cost too much then. */
export function drawsInSoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class Stage {
  /** @param extent what is drawn over the whole motion @param {boolean} isSlow whether there is no graphics card */
  constructor(canvas, description, extent, isSlow) {
    this.canvas = canvas;
    this.size = description.size;
    this.extent = extent;
    this.isPlanar = description.dimension === 2;
    this.up = new Vector3(...description.up).normalize();
    this.fromZ = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), this.up);
    this.isSlow = isSlow;
    // Opaque: the browser needn't draw the page behind it.
    const context = canvas.getContext("webgl2", { alpha: false, antialias: !this.isSlow, preserveDrawingBuffer: true });
    if (!context) throw new Error("no WebGL");
    this.renderer = new WebGLRenderer({ canvas, context });
    this.finest = Math.min(window.devicePixelRatio, 2);
    this.ratio = this.finest;
    this.pace = 0;
    this.renderer.setPixelRatio(this.ratio);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1.6, 0.01 * this.size, 60 * this.size);
    this.camera.up.copy(this.up);
    const sky = new HemisphereLight(0xffffff, 0x7c8894, 1.7);
    sky.position.copy(this.up);
    this.sun = new DirectionalLight(0xffffff, 2.1);
    this.scene.add(sky, this.sun, this.camera);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    // One finger up and down scrolls the page, sideways it turns; two fingers turn and come nearer.
    this.controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_ROTATE };
    canvas.style.touchAction = "pan-y";
    this.controls.addEventListener("start", () => (this.view = null));
    this.grid = null;
    this.axes = new AxesHelper(0.08 * this.size);
    this.scene.add(this.axes);
    this.look("home");
  }

  /** The grid under everything. */
  ground() {
    const step = 10 ** Math.round(Math.log10(this.size / 8));
    const count = 2 * Math.ceil((0.9 * this.size) / step);
    if (this.grid) this.grid.removeFromParent();
    this.grid = new GridHelper(count * step, count, 0x8a94a0, 0x8a94a0);
    this.grid.material.transparent = true;
    this.grid.material.depthWrite = false;
    const { center, lowest } = this.extent;
    if (this.isPlanar) {
      this.grid.rotation.x = Math.PI / 2;
      this.grid.position.set(center.x, center.y, -0.05 * this.size);
    } else {
      this.grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), this.up);
      this.grid.position.copy(center).addScaledVector(this.up, lowest - center.dot(this.up) - 0.03 * this.size);
    }
    this.#tone();
    this.scene.add(this.grid);
  }

  theme(isDark) {
    this.isDark = isDark;
    this.scene.background = new Color(isDark ? 0x1b2026 : 0xeef1f4);
    this.#tone();
  }

  #tone() {
    if (this.grid) this.grid.material.opacity = this.isDark ? 0.22 : 0.35;
  }

  /** One of the standard views: all of the motion is seen. */
  look(name) {
    this.view = name;
    const direction = new Vector3(...VIEWS[name]).normalize();
    if (this.isPlanar && name === "home") direction.set(0, 0, 1);
    else if (!this.isPlanar) direction.applyQuaternion(this.fromZ);
    const { target, distance } = fit(this.extent, direction, this.up, Math.tan((0.5 * this.camera.fov * Math.PI) / 180), this.camera.aspect);
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(direction, Math.max(distance, 0.1 * this.size));
    this.controls.update();
  }

  /** Turns the camera about what it looks at, or comes nearer. */
  move(sideways, upwards, nearer) {
    this.view = null;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const side = new Vector3().crossVectors(this.up, offset).normalize();
    offset.applyAxisAngle(this.up, sideways).applyAxisAngle(side, -upwards).multiplyScalar(nearer);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    if (this.view) this.look(this.view);
  }

  /** Draws coarser while it moves if a picture takes too long. @param {number} passed milliseconds since the last picture */
  keepPace(passed) {
    this.pace = 0.8 * this.pace + 0.2 * passed;
    if (this.pace > SLOW && this.ratio > COARSEST) this.#drawWith(Math.max(COARSEST, 0.8 * this.ratio));
  }

  /** As fine as the screen again; whether that changed anything. */
  sharpen() {
    if (this.ratio === this.finest) return false;
    this.#drawWith(this.finest);
    return true;
  }

  #drawWith(ratio) {
    this.ratio = ratio;
    this.pace = 0;
    // Smoothing of enlarged pixels costs a software renderer more than drawing them.
    this.canvas.style.imageRendering = this.isSlow && ratio < this.finest ? "pixelated" : "";
    const { clientWidth, clientHeight } = this.canvas;
    this.renderer.setPixelRatio(ratio);
    if (clientWidth > 0) this.renderer.setSize(clientWidth, clientHeight, false);
  }

  draw() {
    const from = this.camera.position.clone().sub(this.controls.target);
    this.sun.position.copy(this.controls.target).add(from).addScaledVector(this.up, 0.8 * from.length());
    this.sun.target.position.copy(this.controls.target);
    this.sun.target.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
  }

  /** What lies under a place of the canvas: {body, point, face} or null. */
  pick(event, bodies) {
    const box = this.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const ray = new Raycaster();
    ray.params.Line.threshold = 0.01 * this.size;
    ray.params.Points.threshold = 0.01 * this.size;
    ray.setFromCamera(at, this.camera);
    const hits = ray.intersectObjects(bodies.map((body) => body.group), true);
    const hit = hits.find((one) => one.object.userData.body);
    return hit ? { body: hit.object.userData.body, hit } : null;
  }
}
