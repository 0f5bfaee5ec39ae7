// What is drawn at a place of a picture: the nearest triangle along the ray there, and the nearest of its points.

import { Vector3 } from "three";

export function nearest(view, x, y) {
  const { camera, model, section } = view;
  camera.updateMatrixWorld();
  const from = new Vector3(x, y, -1).unproject(camera);
  const along = new Vector3(0, 0, -1).transformDirection(camera.matrixWorld);
  const ray = { from: from.toArray(), along: along.toArray() };
  let best = null;
  const test = (triangles, t, where) => {
    const points = [triangles[t], triangles[t + 1], triangles[t + 2]];
    const hit = meet(ray, ...points.map((p) => view.place(p)));
    if (hit !== null && (best === null || hit < best.hit)) best = { hit, points, where };
  };
  const per = 3 * model.trianglesPerFace;
  const faces = section ? section.faces : { length: model.faceCount };
  for (let i = 0; i < faces.length; i++) {
    const face = section ? faces[i] : i;
    for (let t = face * per; t < (face + 1) * per; t += 3) test(model.triangles, t, { face });
  }
  if (section) for (let t = 0; t < section.triangles.length; t += 3) test(section.triangles, t, { cell: section.cellOf(t / 3) });
  if (!best) return null;
  const at = ray.from.map((p, c) => p + best.hit * ray.along[c]);
  const far = (p) => Math.hypot(...view.place(p).map((q, c) => q - at[c]));
  return { point: best.points.reduce((a, b) => (far(b) < far(a) ? b : a)), where: best.where };
}

/** How far along a ray a triangle is, or null (Moeller and Trumbore, 1997). */
function meet({ from, along }, a, b, c) {
  const [ux, uy, uz] = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
  const [vx, vy, vz] = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
  const [px, py, pz] = [along[1] * vz - along[2] * vy, along[2] * vx - along[0] * vz, along[0] * vy - along[1] * vx];
  const determinant = ux * px + uy * py + uz * pz;
  if (determinant === 0) return null;
  const [sx, sy, sz] = [from[0] - a[0], from[1] - a[1], from[2] - a[2]];
  const r = (sx * px + sy * py + sz * pz) / determinant;
  if (r < 0 || r > 1) return null;
  const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
  const s = (along[0] * qx + along[1] * qy + along[2] * qz) / determinant;
  if (s < 0 || r + s > 1) return null;
  return (vx * qx + vy * qy + vz * qz) / determinant;
}
