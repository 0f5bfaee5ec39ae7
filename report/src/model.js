// A step as geometry: its surface, its cells and what a cut through them shows; the fields on them.

const TRIANGLE = { triangles: [0, 1, 2], lines: [0, 1, 1, 2, 2, 0], corners: [0, 1, 2] };
const TRIANGLE6 = {
  triangles: [0, 3, 5, 3, 1, 4, 5, 4, 2, 3, 4, 5],
  lines: [0, 3, 3, 1, 1, 4, 4, 2, 2, 5, 5, 0],
  corners: [0, 1, 2],
};
const TET_FACES = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
const HEX_FACES = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

function square(side) {
  const [triangles, lines, last] = [[], [], side - 1];
  for (let j = 0; j < last; j++) {
    for (let i = 0; i < last; i++) {
      const [a, b, c, d] = [i + side * j, i + 1 + side * j, i + 1 + side * (j + 1), i + side * (j + 1)];
      triangles.push(a, b, c, a, c, d);
    }
  }
  for (let i = 0; i < last; i++) {
    lines.push(i, i + 1, last + side * i, last + side * (i + 1));
    lines.push(side * last + i + 1, side * last + i, side * (i + 1), side * i);
  }
  return { triangles, lines, corners: [0, last, side * side - 1, side * last] };
}

/** How a face of so many points is cut into triangles, and its sides into lines. */
export function pattern(points) {
  return points === 3 ? TRIANGLE : points === 6 ? TRIANGLE6 : square(Math.round(Math.sqrt(points)));
}

/** For each face of a cell the places of its points among the cell's. */
function cellFaces(points) {
  if (points === 4) return TET_FACES;
  const side = Math.round(Math.cbrt(points));
  const corner = (c) => [c & 1, (c >> 1) & 1, c >> 2].map((b) => b * (side - 1));
  return HEX_FACES.map(([a, b, , d]) => {
    const [p, q, r] = [a, b, d].map(corner);
    const places = [];
    for (let j = 0; j < side; j++) {
      for (let i = 0; i < side; i++) {
        const at = p.map((x, k) => x + (i * (q[k] - x) + j * (r[k] - x)) / (side - 1));
        places.push(at[0] + side * (at[1] + side * at[2]));
      }
    }
    return places;
  });
}

export const FIELDS = {
  displacement: { name: "Displacement, length", at: "point", unit: "length" },
  ux: { name: "Displacement along x", at: "point", unit: "length", signed: true },
  uy: { name: "Displacement along y", at: "point", unit: "length", signed: true },
  uz: { name: "Displacement along z", at: "point", unit: "length", signed: true },
  von_mises: { name: "Von Mises stress", at: "point", unit: "stress" },
  principal_max: { name: "Largest principal stress", at: "point", unit: "stress", signed: true },
  principal_min: { name: "Smallest principal stress", at: "point", unit: "stress", signed: true },
  error: { name: "Estimated error of each cell (energy norm)", at: "cell", log: true },
  quality: { name: "Smallest angle of each cell", at: "cell", fixedUnit: "°" },
  level: { name: "Refinement level of each cell", at: "cell", whole: true },
};

export class Model {
  constructor(arrays, info) {
    Object.assign(this, { arrays, info });
    this.count = info.points;
    this.points = arrays.points;
    this.displacement = arrays.displacement;
    this.pattern = pattern(info.face_points);
    this.faceCount = arrays.faces.length / info.face_points;
    const local = this.pattern.triangles;
    this.trianglesPerFace = local.length / 3;
    this.triangles = new Uint32Array(this.faceCount * local.length);
    for (let f = 0; f < this.faceCount; f++) {
      for (let i = 0; i < local.length; i++) this.triangles[f * local.length + i] = arrays.faces[f * info.face_points + local[i]];
    }
    this.measure();
  }

  measure() {
    const [lo, hi] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    let moved = 0;
    for (let i = 0; i < this.count; i++) {
      for (let c = 0; c < 3; c++) {
        lo[c] = Math.min(lo[c], this.points[3 * i + c]);
        hi[c] = Math.max(hi[c], this.points[3 * i + c]);
      }
      moved = Math.max(moved, Math.hypot(...this.displacement.subarray(3 * i, 3 * i + 3)));
    }
    Object.assign(this, { lo, hi, moved, diagonal: Math.hypot(hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]) });
  }

  /** The values of a field at points, or in the cells of faces and in the cells drawn. Of errors the logarithms. */
  field(key) {
    const { arrays, count } = this;
    if (FIELDS[key].at === "cell") {
      const of = (values) => (FIELDS[key].log ? Float32Array.from(values, (e) => (e > 0 ? Math.log10(e) : NaN)) : Float32Array.from(values));
      return { faces: of(arrays[`face_${key}`]), cells: of(arrays[`cell_${key}`]) };
    }
    const out = new Float32Array(count);
    const u = this.displacement;
    const column = { ux: 0, uy: 1, uz: 2, von_mises: 0, principal_max: 1, principal_min: 2 }[key];
    for (let i = 0; i < count; i++) {
      if (key === "displacement") out[i] = Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2]);
      else out[i] = (key[0] === "u" ? u : arrays.stress)[3 * i + column];
    }
    return { points: out };
  }

  /** The limits of a field at points between which 98 % of the surface lie, 1 % beyond each. */
  withoutPeaks(values) {
    const { triangles } = this;
    const count = triangles.length / 3;
    if (!this.areas) {
      this.areas = new Float32Array(count);
      for (let t = 0; t < count; t++) {
        const [a, b, c] = [0, 1, 2].map((k) => this.points.subarray(3 * triangles[3 * t + k], 3 * triangles[3 * t + k] + 3));
        this.areas[t] = Math.hypot(...cross(a, b, c));
      }
    }
    const means = new Float32Array(count);
    for (let t = 0; t < count; t++) means[t] = (values[triangles[3 * t]] + values[triangles[3 * t + 1]] + values[triangles[3 * t + 2]]) / 3;
    const order = Uint32Array.from(means, (_, t) => t).sort((s, t) => means[s] - means[t]);
    const whole = this.areas.reduce((sum, a) => sum + a, 0);
    const at = (list) => {
      let sum = 0;
      for (const t of list) if ((sum += this.areas[t]) >= 0.01 * whole) return means[t];
      return means[list.at(-1)];
    };
    return [at(order), at(order.reverse())];
  }

  /** Codes of the faces: 1 held, 2 loaded. */
  faceMarks(marks) {
    const patches = this.info.patches.map((list) => {
      const what = new Set(list.map((m) => marks[m].what));
      return what.has("load") ? 2 : what.has("support") ? 1 : 0;
    });
    return Uint8Array.from(this.arrays.face_patches, (p) => patches[p] ?? 0);
  }

  /** Where the faces of a mark are: the mean of their corners by area, the mean normal, and their area. */
  whereabouts(mark) {
    const member = this.info.patches.map((list) => list.includes(mark));
    const [centre, normal] = [[0, 0, 0], [0, 0, 0]];
    let area = 0;
    for (let t = 0; t < this.triangles.length; t += 3) {
      if (!member[this.arrays.face_patches[Math.floor(t / 3 / this.trianglesPerFace)]]) continue;
      const [a, b, c] = [0, 1, 2].map((k) => this.points.subarray(3 * this.triangles[t + k], 3 * this.triangles[t + k] + 3));
      const n = cross(a, b, c);
      const size = Math.hypot(...n);
      area += size;
      for (let k = 0; k < 3; k++) {
        normal[k] += n[k];
        centre[k] += (size * (a[k] + b[k] + c[k])) / 3;
      }
    }
    if (!area) return null;
    const middle = centre.map((x) => x / area);
    return { centre: middle, spot: this.nearestOf(member, middle), normal: normal.map((x) => x / area), area: area / 2 };
  }

  /** The point of some faces that is nearest to a place. */
  nearestOf(member, place) {
    const size = this.info.face_points;
    let [best, at] = [Infinity, place];
    for (let f = 0; f < this.faceCount; f++) {
      if (!member[this.arrays.face_patches[f]]) continue;
      const v = this.arrays.faces[f * size];
      const p = [0, 1, 2].map((c) => this.points[3 * v + c]);
      const far = Math.hypot(...p.map((x, c) => x - place[c]));
      if (far < best) [best, at] = [far, p];
    }
    return at;
  }

  /** The cell across each face of each cell, or -1; and the middles of the cells. */
  neighbours() {
    if (this.across) return;
    const { cells } = this.arrays;
    const size = this.info.cell_points;
    this.cellFaces = cellFaces(size);
    const faces = this.cellFaces;
    const corners = pattern(faces[0].length).corners;
    this.cellCount = cells.length / size;
    const rank = new Map();
    const ranked = (v) => rank.get(v) ?? rank.set(v, rank.size).get(v);
    for (let t = 0; t < this.cellCount; t++) {
      for (const places of faces) for (const c of corners) ranked(cells[t * size + places[c]]);
    }
    const base = rank.size;
    const open = new Map();
    this.across = new Int32Array(this.cellCount * faces.length).fill(-1);
    this.middles = new Float64Array(3 * this.cellCount);
    for (let t = 0; t < this.cellCount; t++) {
      faces.forEach((places, k) => {
        const [a, b, c] = corners.map((q) => rank.get(cells[t * size + places[q]])).sort((x, y) => x - y);
        const key = a + base * (b + base * c);
        const own = t * faces.length + k;
        const other = open.get(key);
        if (other === undefined) open.set(key, own);
        else {
          this.across[own] = Math.floor(other / faces.length);
          this.across[other] = t;
          open.delete(key);
        }
      });
      for (let q = 0; q < size; q++) {
        for (let x = 0; x < 3; x++) this.middles[3 * t + x] += this.points[3 * cells[t * size + q] + x] / size;
      }
    }
  }

  /** What is left where cells beyond a plane are taken away: faces of the surface, and faces of cells (cell, face). */
  cut({ axis, offset, flip }) {
    this.neighbours();
    // What is nearer to the first view is taken away.
    const sign = flip !== (axis === 1) ? -1 : 1;
    const stays = (x) => sign * (x - offset) <= 0;
    const keep = Uint8Array.from({ length: this.cellCount }, (_, t) => (stays(this.middles[3 * t + axis]) ? 1 : 0));
    const whole = this.info.merged === null && this.cellCount === this.info.cells;
    const faces = [];
    const { corners } = this.pattern;
    for (let f = 0; f < this.faceCount; f++) {
      let visible;
      if (whole) visible = keep[this.arrays.face_cells[f]];
      else {
        const at = corners.reduce((sum, c) => sum + this.points[3 * this.arrays.faces[f * this.info.face_points + c] + axis], 0);
        visible = stays(at / corners.length);
      }
      if (visible) faces.push(f);
    }
    const inner = [];
    const n = this.cellFaces.length;
    for (let t = 0; t < this.cellCount; t++) {
      if (!keep[t]) continue;
      for (let k = 0; k < n; k++) if (this.across[t * n + k] >= 0 && !keep[this.across[t * n + k]]) inner.push(t * n + k);
    }
    return { faces: Uint32Array.from(faces), inner: Uint32Array.from(inner), kept: keep.reduce((a, b) => a + b, 0) };
  }

  /** The points of a face of a cell, given as one number. */
  cellFacePoints(own) {
    const n = this.cellFaces.length;
    const t = Math.floor(own / n);
    return this.cellFaces[own % n].map((q) => this.arrays.cells[t * this.info.cell_points + q]);
  }

  /** What is known at a point and in a cell, for people. */
  at(point, { face, cell }) {
    const { arrays } = this;
    const of = (name) => (face !== undefined ? arrays[`face_${name}`][face] : arrays[`cell_${name}`][cell]);
    const id = face !== undefined ? arrays.face_cells[face] : arrays.cell_ids ? arrays.cell_ids[cell] : cell;
    return {
      point: arrays.ids[point],
      position: [...this.points.subarray(3 * point, 3 * point + 3)],
      displacement: [...this.displacement.subarray(3 * point, 3 * point + 3)],
      stress: [...arrays.stress.subarray(3 * point, 3 * point + 3)],
      cell: id, error: of("error"), quality: of("quality"), level: of("level"),
    };
  }

  /** Half a step of the codes of an array: how far a value may be off. */
  rounding(name) {
    return Math.max(...this.arrays.limits[name].map(([lo, hi]) => (hi - lo) / 65534 / 2));
  }
}

export function cross(a, b, c) {
  const [u, v] = [[b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]];
  return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
}
