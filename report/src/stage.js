// The canvas of a picture, its camera, and what turns it.

import { Color, MOUSE, OrthographicCamera, Scene, TOUCH, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

export class Stage {
  constructor() {
    Object.assign(this, { scene: new Scene(), camera: new OrthographicCamera(-1, 1, 1, -1, -10, 10) });
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.PAN };
    this.controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    this.controls.addEventListener("change", () => {
      this.draw();
      this.onCamera?.(this);
    });
    this.listen();
  }

  listen() {
    let down = null;
    this.canvas.addEventListener("pointerdown", (e) => (down = [e.clientX, e.clientY]));
    this.canvas.addEventListener("pointerup", (e) => {
      if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < 4) {
        const box = this.canvas.getBoundingClientRect();
        this.pick((2 * (e.clientX - box.left)) / box.width - 1, 1 - (2 * (e.clientY - box.top)) / box.height);
      }
    });
    this.canvas.addEventListener("keydown", (e) => {
      const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
      if (turn) this.turn(turn[0] * 0.12, turn[1] * 0.12);
      else if (e.key === "+" || e.key === "=") this.zoom(1.15);
      else if (e.key === "-") this.zoom(1 / 1.15);
      else if (e.key === "r") this.home();
      else if (e.key === "Enter") this.pick(0, 0);
      else return;
      e.preventDefault();
    });
  }

  home(direction = [0.62, -0.9, 0.55]) {
    const size = this.model.diagonal || 1;
    this.camera.position.set(...direction).setLength(2 * size);
    this.camera.near = -4 * size;
    this.camera.far = 8 * size;
    this.controls.target.set(0, 0, 0);
    this.camera.zoom = 1;
    this.camera.lookAt(0, 0, 0);
    this.camera.updateMatrixWorld();
    this.fit();
    this.controls.update();
    this.draw();
    this.onCamera?.(this);
  }

  /** The half height that holds the model's box from here. */
  fit() {
    const { lo, hi } = this.model;
    let [wide, high] = [1e-30, 1e-30];
    for (let c = 0; c < 8; c++) {
      const corner = new Vector3(...[0, 1, 2].map((k) => ((c >> k) & 1 ? hi[k] : lo[k]) - this.origin[k])).applyMatrix4(this.camera.matrixWorldInverse);
      wide = Math.max(wide, Math.abs(corner.x));
      high = Math.max(high, Math.abs(corner.y));
    }
    this.extent = [wide, high];
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height || !this.model) return;
    this.renderer.setSize(width, height, false);
    const [wide, high] = this.extent;
    const half = 1.14 * Math.max(high, (wide * height) / width);
    Object.assign(this.camera, { top: half, bottom: -half, left: (-half * width) / height, right: (half * width) / height });
    this.camera.updateProjectionMatrix();
    this.render();
  }

  turn(across, down) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(new Vector3(0, 0, 1), across);
    const right = new Vector3().crossVectors(offset, this.camera.up).normalize();
    const turned = offset.clone().applyAxisAngle(right, -down);
    if (Math.abs(turned.clone().normalize().z) < 0.995) offset.copy(turned);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  zoom(factor) {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
    this.onCamera?.(this);
  }

  /** Looks from where another view looks. */
  follow(other) {
    this.camera.position.copy(other.camera.position);
    this.controls.target.copy(other.controls.target);
    this.camera.zoom = other.camera.zoom;
    this.camera.updateProjectionMatrix();
    this.camera.lookAt(this.controls.target);
    this.draw();
  }

  draw() {
    this.due ??= requestAnimationFrame(() => this.render());
  }

  render() {
    if (this.due) cancelAnimationFrame(this.due);
    this.due = null;
    if (!this.model) return;
    const ground = this.printed ? "#ffffff" : getComputedStyle(document.body).getPropertyValue("--canvas").trim();
    this.renderer.setClearColor(new Color(ground), 1);
    this.renderer.render(this.scene, this.camera);
    this.overlay.update();
  }
}
