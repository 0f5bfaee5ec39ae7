// Triangles and lines of a model for the graphics card, moved there by the deformation.

import { BufferAttribute, BufferGeometry, DataTexture, DoubleSide, GLSL3, LinearFilter, ShaderMaterial } from "three";
import { colours } from "./colour.js";

const NONE = -3e38;

const moved = /* glsl */ `
  in vec3 shift;
  uniform float amount;
  vec4 placed() { return projectionMatrix * modelViewMatrix * vec4(position + amount * shift, 1.0); }
`;

const vertex = /* glsl */ `
  ${moved}
  in float value;
  in float mark;
  out float vValue;
  out vec3 vNormal;
  out vec3 vPlace;
  flat out float vMark;
  void main() {
    vValue = value;
    vMark = mark;
    vNormal = normalMatrix * normal;
    vPlace = (modelViewMatrix * vec4(position + amount * shift, 1.0)).xyz;
    gl_Position = placed();
  }
`;

const fragment = /* glsl */ `
  precision highp float;
  in float vValue;
  in vec3 vNormal;
  in vec3 vPlace;
  flat in float vMark;
  uniform sampler2D map;
  uniform vec2 range;
  uniform bool plain;
  uniform bool faceted;
  uniform bool marked;
  uniform vec3 held;
  uniform vec3 loaded;
  out vec4 colour;
  void main() {
    vec3 base = vec3(0.70, 0.72, 0.74);
    if (!plain && vValue > -1e38) {
      float t = clamp((vValue - range.x) / max(range.y - range.x, 1e-38), 0.0, 1.0);
      base = texture(map, vec2(t * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
    }
    if (marked && vMark > 0.5) {
      float stripe = mod(gl_FragCoord.x + (vMark > 1.5 ? gl_FragCoord.y : -gl_FragCoord.y), 11.0);
      if (stripe < 2.6) base = mix(base, vMark > 1.5 ? loaded : held, 0.7);
    }
    vec3 n = faceted ? normalize(cross(dFdx(vPlace), dFdy(vPlace))) : normalize(vNormal) * (gl_FrontFacing ? 1.0 : -1.0);
    if (n.z < 0.0) n = -n;
    float light = 0.70 + 0.26 * max(dot(n, normalize(vec3(-0.35, 0.55, 0.76))), 0.0) + 0.10 * n.z;
    colour = vec4(base * min(light, 1.04), 1.0);
  }
`;

export function surfaceMaterial() {
  const map = new DataTexture(colours(false), 256, 1);
  map.magFilter = map.minFilter = LinearFilter;
  map.needsUpdate = true;
  return new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: vertex,
    fragmentShader: fragment,
    side: DoubleSide,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    uniforms: {
      amount: { value: 0 }, map: { value: map }, range: { value: [0, 1] }, plain: { value: false }, faceted: { value: false },
      marked: { value: true }, held: { value: [0.12, 0.42, 0.78] }, loaded: { value: [0.84, 0.30, 0.08] },
    },
  });
}

export function lineMaterial(colour, opacity) {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: `${moved} void main() { gl_Position = placed(); gl_Position.z -= 2e-4 * gl_Position.w; }`,
    fragmentShader: "precision highp float; uniform vec4 ink; out vec4 colour; void main() { colour = ink; }",
    transparent: opacity < 1,
    uniforms: { amount: { value: 0 }, ink: { value: [...colour, opacity] } },
  });
}

const attribute = (array, width) => new BufferAttribute(array, width);

/** A geometry of corners: three a triangle, none shared, so that cells can have colours of their own. */
export function cornerGeometry(model, triangles, origin) {
  const geometry = new BufferGeometry();
  const gather = (from, [x, y, z]) => {
    const out = new Float32Array(3 * triangles.length);
    for (let i = 0; i < triangles.length; i++) {
      const v = 3 * triangles[i];
      out[3 * i] = from[v] - x;
      out[3 * i + 1] = from[v + 1] - y;
      out[3 * i + 2] = from[v + 2] - z;
    }
    return out;
  };
  geometry.setAttribute("position", attribute(gather(model.points, origin), 3));
  geometry.setAttribute("shift", attribute(gather(model.displacement, [0, 0, 0]), 3));
  geometry.setAttribute("normal", attribute(new Float32Array(3 * triangles.length), 3));
  geometry.setAttribute("value", attribute(new Float32Array(triangles.length), 1));
  geometry.setAttribute("mark", attribute(new Float32Array(triangles.length), 1));
  return geometry;
}

/** Sets the values of corners: those of their points, or those of the cell of their triangle. */
export function setValues(geometry, triangles, { points, cells }, cellOf) {
  const out = geometry.attributes.value.array;
  for (let i = 0; i < triangles.length; i++) {
    const x = points ? points[triangles[i]] : cells[cellOf(Math.floor(i / 3))];
    out[i] = Number.isFinite(x) ? x : NONE;
  }
  geometry.attributes.value.needsUpdate = true;
}

/** Normals of corners: the mean of those triangles at the point that turn by less than an angle in degrees. */
export function setNormals(geometry, triangles, count, amount, angle) {
  const [position, shift] = [geometry.attributes.position.array, geometry.attributes.shift.array];
  const at = (i) => position[i] + amount * shift[i];
  const flat = new Float32Array(triangles.length);
  const own = new Float32Array(triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const p = 3 * t;
    const [ax, ay, az] = [at(p), at(p + 1), at(p + 2)];
    const [ux, uy, uz] = [at(p + 3) - ax, at(p + 4) - ay, at(p + 5) - az];
    const [vx, vy, vz] = [at(p + 6) - ax, at(p + 7) - ay, at(p + 8) - az];
    flat[t] = uy * vz - uz * vy;
    flat[t + 1] = uz * vx - ux * vz;
    flat[t + 2] = ux * vy - uy * vx;
    const size = Math.hypot(flat[t], flat[t + 1], flat[t + 2]) || 1;
    for (let k = 0; k < 3; k++) own[t + k] = flat[t + k] / size;
  }
  const starts = new Uint32Array(count + 1);
  for (const v of triangles) starts[v + 1]++;
  for (let v = 0; v < count; v++) starts[v + 1] += starts[v];
  const next = starts.slice();
  const around = new Uint32Array(triangles.length);
  for (let i = 0; i < triangles.length; i++) around[next[triangles[i]]++] = i - (i % 3);
  const least = Math.cos((angle * Math.PI) / 180);
  const out = geometry.attributes.normal.array;
  for (let i = 0; i < triangles.length; i++) {
    const t = i - (i % 3);
    let [x, y, z] = [0, 0, 0];
    for (let j = starts[triangles[i]]; j < starts[triangles[i] + 1]; j++) {
      const o = around[j];
      if (own[t] * own[o] + own[t + 1] * own[o + 1] + own[t + 2] * own[o + 2] < least && o !== t) continue;
      x += flat[o];
      y += flat[o + 1];
      z += flat[o + 2];
    }
    const size = Math.hypot(x, y, z) || 1;
    out[3 * i] = x / size;
    out[3 * i + 1] = y / size;
    out[3 * i + 2] = z / size;
  }
  geometry.attributes.normal.needsUpdate = true;
}

/** A geometry of lines between the points of a model. */
export function lineGeometry(model, indices, origin) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", attribute(Float32Array.from(model.points, (x, i) => x - origin[i % 3]), 3));
  geometry.setAttribute("shift", attribute(Float32Array.from(model.displacement), 3));
  geometry.setIndex(attribute(indices, 1));
  return geometry;
}

/** The sides of faces as pairs of points, each once. */
export function sides(faces, pattern) {
  const out = [];
  const seen = new Set();
  for (const points of faces) {
    for (let i = 0; i < pattern.lines.length; i += 2) {
      const [a, b] = [points[pattern.lines[i]], points[pattern.lines[i + 1]]];
      const key = a < b ? a * 4194304 + b : b * 4194304 + a;
      if (seen.has(key)) continue;
      seen.add(key);
      out.push(a, b);
    }
  }
  return Uint32Array.from(out);
}
