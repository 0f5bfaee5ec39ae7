// A picture of a step that can be turned, cut and picked.

import { BufferAttribute, LineSegments, Mesh } from "three";
import { colours, limits } from "./colour.js";
import { FIELDS, pattern } from "./model.js";
import { Overlay } from "./overlay.js";
import { nearest } from "./pick.js";
import { Stage } from "./stage.js";
import { cornerGeometry, lineGeometry, lineMaterial, setNormals, setValues, sides, surfaceMaterial } from "./surface.js";

/** Above this many triangles, shading is by triangle while the deformation changes, or at all. */
const MANY = 150_000;
const AXES = { x: 0, y: 1, z: 2 };

export class View extends Stage {
  constructor(run, label) {
    super();
    Object.assign(this, { run, label });
    this.overlay = new Overlay(this);
    this.material = surfaceMaterial();
    this.cutMaterial = surfaceMaterial();
    this.cutMaterial.uniforms.faceted.value = true;
    this.edgeMaterial = lineMaterial([0.05, 0.08, 0.12], 0.38);
    this.featureMaterial = lineMaterial([0.04, 0.06, 0.09], 1);
    this.element = this.overlay.element;
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** Shows a model in a state of the page. */
  show(model, state) {
    const first = !this.model;
    if (this.model !== model) {
      this.model = model;
      this.unpick();
      this.origin ??= model.lo.map((x, c) => (x + model.hi[c]) / 2);
      this.build();
    }
    this.state = state;
    this.field();
    this.cut();
    this.move(true);
    if (first) this.home();
    this.overlay.labels();
    this.draw();
  }

  build() {
    for (const old of [this.surface, this.features, this.lines, this.inside]) {
      if (!old) continue;
      this.scene.remove(old);
      old.geometry.dispose();
    }
    const { model, origin } = this;
    this.surface = new Mesh(cornerGeometry(model, model.triangles, origin), this.material);
    const marks = model.faceMarks(this.run.marks);
    const out = this.surface.geometry.attributes.mark.array;
    const corners = 3 * model.trianglesPerFace;
    for (let i = 0; i < out.length; i++) out[i] = marks[Math.floor(i / corners)];
    this.features = new LineSegments(lineGeometry(model, model.arrays.lines, origin), this.featureMaterial);
    this.lines = new LineSegments(lineGeometry(model, new Uint32Array(0), origin), this.edgeMaterial);
    this.inside = null;
    this.lineFor = null;
    this.surface.frustumCulled = this.features.frustumCulled = this.lines.frustumCulled = false;
    this.scene.add(this.surface, this.features, this.lines);
  }

  /** The range of the field's values, in logarithms where it is shown so. */
  range(field = this.state.field, robust = this.state.robust) {
    if (!FIELDS[field]) return [0, 1];
    const { points, faces, cells } = this.model.field(field);
    let [lo, hi] = limits(points ? [points] : [faces, cells]);
    if (robust && points) [lo, hi] = this.model.withoutPeaks(points);
    if (FIELDS[field].log && hi - lo > 5) lo = hi - 5;
    return [lo, hi];
  }

  field() {
    const { field } = this.state;
    for (const material of [this.material, this.cutMaterial]) {
      material.uniforms.plain.value = !FIELDS[field];
      material.uniforms.marked.value = this.state.actions;
    }
    if (!FIELDS[field]) return;
    this.values = this.model.field(field);
    const { points, faces } = this.values;
    setValues(this.surface.geometry, this.model.triangles, { points, cells: faces }, (t) => Math.floor(t / this.model.trianglesPerFace));
  }

  /** Colours between these limits; of values on both sides of zero, with zero in the middle. */
  setRange([lo, hi]) {
    const diverging = Boolean(FIELDS[this.state.field]?.signed && lo < 0 && hi > 0);
    const most = Math.max(-lo, hi);
    const range = diverging ? [-most, most] : [lo, hi];
    for (const { uniforms } of [this.material, this.cutMaterial]) {
      uniforms.range.value = range;
      uniforms.map.value.image.data.set(colours(diverging));
      uniforms.map.value.needsUpdate = true;
    }
    this.draw();
    return { range, diverging };
  }

  cut() {
    const { model, state } = this;
    if (this.inside) {
      this.scene.remove(this.inside);
      this.inside.geometry.dispose();
      this.inside = null;
    }
    this.section = null;
    const axis = AXES[state.clip.axis];
    if (axis === undefined) {
      this.surface.geometry.setIndex(null);
      this.edges(null);
      return;
    }
    const offset = model.lo[axis] + state.clip.at * (model.hi[axis] - model.lo[axis]);
    this.section = model.cut({ axis, offset, flip: state.clip.flip });
    const { faces, inner } = this.section;
    const per = 3 * model.trianglesPerFace;
    const index = new Uint32Array(faces.length * per);
    faces.forEach((f, i) => {
      for (let k = 0; k < per; k++) index[i * per + k] = f * per + k;
    });
    this.surface.geometry.setIndex(new BufferAttribute(index, 1));
    this.innerFaces(inner);
    this.edges(faces);
  }

  innerFaces(inner) {
    const { model } = this;
    const places = Array.from(inner, (own) => model.cellFacePoints(own));
    const cut = pattern(model.cellFaces[0].length);
    const triangles = Uint32Array.from(places.flatMap((points) => cut.triangles.map((q) => points[q])));
    const each = cut.triangles.length / 3;
    const geometry = cornerGeometry(model, triangles, this.origin);
    this.section.triangles = triangles;
    this.section.places = places;
    this.section.pattern = cut;
    this.section.cellOf = (t) => Math.floor(inner[Math.floor(t / each)] / model.cellFaces.length);
    if (this.values && FIELDS[this.state.field]) setValues(geometry, triangles, this.values, this.section.cellOf);
    this.inside = new Mesh(geometry, this.cutMaterial);
    this.inside.frustumCulled = false;
    this.scene.add(this.inside);
  }

  /** Lines of the sides of faces: of all, or of these and of the cells that the cut shows. */
  edges(faces) {
    this.lines.visible = this.state.edges;
    this.features.visible = this.state.features && !this.section;
    if (!this.state.edges) return;
    const { model } = this;
    const size = model.info.face_points;
    const of = (f) => model.arrays.faces.subarray(f * size, (f + 1) * size);
    if (!faces && this.lineFor === model) {
      this.lines.geometry.setIndex(this.allLines);
      return;
    }
    const chosen = faces ? Array.from(faces, of) : Array.from({ length: model.faceCount }, (_, f) => of(f));
    let lines = sides(chosen, model.pattern);
    if (this.section) {
      const inner = sides(this.section.places, this.section.pattern);
      const both = new Uint32Array(lines.length + inner.length);
      both.set(lines);
      both.set(inner, lines.length);
      lines = both;
    }
    const attribute = new BufferAttribute(lines, 1);
    this.lines.geometry.setIndex(attribute);
    if (!faces) [this.lineFor, this.allLines] = [model, attribute];
  }

  /** Moves everything by the displacement times `state.amount`; `settled` unless that is still changing. */
  move(settled) {
    const { amount } = this.state;
    const few = this.model.triangles.length / 3 <= MANY;
    for (const material of [this.material, this.cutMaterial, this.edgeMaterial, this.featureMaterial]) material.uniforms.amount.value = amount;
    this.material.uniforms.faceted.value = !few;
    if (few && (settled || this.model.triangles.length < MANY / 2)) {
      setNormals(this.surface.geometry, this.model.triangles, this.model.count, amount, this.run.feature_angle);
    }
    this.draw();
  }

  /** Where a point is drawn. */
  place(point) {
    const { points, displacement } = this.model;
    return [0, 1, 2].map((c) => points[3 * point + c] - this.origin[c] + this.state.amount * displacement[3 * point + c]);
  }

  /** Picks what is drawn at a place from -1 to 1; the page hears of it. */
  pick(x, y) {
    const found = nearest(this, x, y);
    if (!found) this.unpick();
    else this.choose(found.point, found.where);
  }

  choose(point, where) {
    this.picked = { index: point, where, ...this.model.at(point, where) };
    this.draw();
    this.onPick?.(this);
  }

  unpick() {
    this.picked = null;
    this.draw();
    this.onPick?.(this);
  }

  /** Picks the point or cell of the surface where the field is largest; of angles where it is smallest. */
  pickExtreme() {
    const { model, state } = this;
    if (!FIELDS[state.field]) return;
    const sign = state.field === "quality" ? -1 : 1;
    const { points, faces } = model.field(state.field);
    const size = model.info.face_points;
    let [best, at] = [-Infinity, 0];
    for (let f = 0; f < model.faceCount; f++) {
      for (let q = 0; q < (points ? size : 1); q++) {
        const x = sign * (points ? points[model.arrays.faces[f * size + q]] : faces[f]);
        if (x > best) [best, at] = [x, f * size + q];
      }
    }
    this.choose(model.arrays.faces[at], { face: Math.floor(at / size) });
  }
}
