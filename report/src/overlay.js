// What lies over a picture: names of supports and loads, arrows of loads, the axes.

import { Vector3 } from "three";
import { h, s } from "./dom.js";
import { direction } from "./words.js";

export class Overlay {
  constructor(view) {
    this.view = view;
    this.arrows = s("svg", { class: "arrows", "aria-hidden": "true" },
      s("defs", {}, s("marker", { id: "tip", viewBox: "0 0 8 8", refX: 6, refY: 4, markerWidth: 5, markerHeight: 5, orient: "auto-start-reverse" },
        s("path", { d: "M0,0 L8,4 L0,8 z" }))));
    this.spot = s("circle", { class: "spot", r: 6 });
    this.arrows.append(this.spot);
    this.names = h("div", { class: "names", "aria-hidden": "true" });
    this.axes = s("svg", { class: "axes", viewBox: "-34 -34 68 68", "aria-hidden": "true" });
    this.element = h("div", { class: "view" }, view.canvas, this.arrows, this.names, this.axes);
    this.marks = [];
  }

  /** Makes the names and arrows of the model shown. */
  labels() {
    const { run, model } = this.view;
    this.marks.forEach(({ name, arrow }) => [name, arrow].forEach((e) => e?.remove()));
    this.marks = [];
    run.marks.forEach((mark, m) => {
      const at = model.whereabouts(m);
      if (!at) return;
      const name = h("span", { class: mark.what }, mark.name);
      const towards = mark.what === "load" ? direction(run.scenario.loads?.[mark.name], at.normal) : null;
      const arrow = towards && s("line", { "marker-end": "url(#tip)" });
      this.names.append(name);
      if (arrow) this.arrows.append(arrow);
      this.marks.push({ name, arrow, towards, at, what: mark.what });
    });
    this.update();
  }

  update() {
    const { view } = this;
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!view.model || !width) return;
    // Parts of the whole, so that they stay in place where a print has another size.
    this.arrows.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const screen = (p) => {
      const v = new Vector3(...p).project(view.camera);
      return [((v.x + 1) / 2) * width, ((1 - v.y) / 2) * height];
    };
    this.spot.setAttribute("visibility", view.picked ? "visible" : "hidden");
    if (view.picked) {
      const [x, y] = screen(view.place(view.picked.index));
      this.spot.setAttribute("cx", x.toFixed(1));
      this.spot.setAttribute("cy", y.toFixed(1));
    }
    for (const { name, arrow, towards, at } of this.marks) {
      const shown = view.state.actions;
      name.hidden = !shown;
      arrow?.setAttribute("visibility", shown ? "visible" : "hidden");
      const centre = (arrow ? at.centre : at.spot).map((x, c) => x - view.origin[c]);
      let [x, y] = screen(centre);
      if (arrow) {
        // Pushing arrows end at the surface, pulling ones begin there.
        const length = 0.16 * view.model.diagonal;
        const pulls = towards.reduce((sum, d, c) => sum + d * at.normal[c], 0) > 1e-9;
        const other = centre.map((p, c) => p + (pulls ? length : -length) * towards[c]);
        const [from, to] = (pulls ? [centre, other] : [other, centre]).map(screen);
        [["x1", from[0]], ["y1", from[1]], ["x2", to[0]], ["y2", to[1]]].forEach(([k, v]) => arrow.setAttribute(k, v.toFixed(1)));
        [x, y] = pulls ? to : from;
      }
      // Faces that look away are behind the body.
      const away = new Vector3(...at.normal).transformDirection(view.camera.matrixWorldInverse).z < -0.05 && Math.hypot(...at.normal) > 0.5;
      name.classList.toggle("behind", away);
      name.style.left = `${((100 * x) / width).toFixed(2)}%`;
      name.style.top = `${((100 * y) / height).toFixed(2)}%`;
    }
    this.drawAxes();
  }

  drawAxes() {
    const parts = ["x", "y", "z"].map((name, c) => {
      const v = new Vector3(+(c === 0), +(c === 1), +(c === 2)).transformDirection(this.view.camera.matrixWorldInverse);
      return { name, x: 22 * v.x, y: -22 * v.y, depth: v.z };
    });
    parts.sort((a, b) => a.depth - b.depth);
    this.axes.replaceChildren(...parts.flatMap(({ name, x, y }) => [
      s("line", { x1: 0, y1: 0, x2: x.toFixed(1), y2: y.toFixed(1) }),
      s("text", { x: (1.38 * x).toFixed(1), y: (1.38 * y).toFixed(1) }, name),
    ]));
  }
}
