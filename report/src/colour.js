// Colour maps, ranges of values and their ticks.

const VIRIDIS = ["472c7a", "3e4a89", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"];
const DIVERGING = ["2b4f9e", "4f7fc4", "8db0dd", "c6d6ea", "e9e6e2", "efc9b3", "df9573", "c25a41", "962a27"];

const rgb = (hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** 256 colours of four bytes. */
export function colours(diverging) {
  const stops = (diverging ? DIVERGING : VIRIDIS).map(rgb);
  const out = new Uint8Array(1024);
  for (let i = 0; i < 256; i++) {
    const x = (i / 255) * (stops.length - 1);
    const k = Math.min(Math.floor(x), stops.length - 2);
    for (let c = 0; c < 3; c++) out[4 * i + c] = Math.round(stops[k][c] + (x - k) * (stops[k + 1][c] - stops[k][c]));
    out[4 * i + 3] = 255;
  }
  return out;
}

export const gradient = (diverging) =>
  `linear-gradient(to right, ${(diverging ? DIVERGING : VIRIDIS).map((c) => `#${c}`).join(", ")})`;

/** Round numbers in a range, about so many. */
export function ticks(lo, hi, wanted = 5) {
  if (!(hi > lo)) return [lo];
  const raw = (hi - lo) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((m) => m >= raw);
  const out = [];
  for (let i = Math.ceil(lo / step - 1e-9); i * step <= hi + 1e-9 * step; i++) out.push(i === 0 ? 0 : Number((i * step).toPrecision(12)));
  return out;
}

/** Powers of ten in a range of logarithms; with 2 and 5 between them if these are few. */
export function decades(lo, hi) {
  const out = [];
  const factors = hi - lo < 0.75 ? [1, 1.5, 2, 3, 4, 5, 6, 8] : hi - lo < 1.6 ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil((hi - lo) / 7));
  for (let d = Math.floor(lo); d <= Math.ceil(hi); d += every) {
    for (const f of factors) {
      const x = d + Math.log10(f);
      if (x >= lo - 1e-9 && x <= hi + 1e-9) out.push(x);
    }
  }
  return out;
}

/** The least and largest known value of some lists. */
export function limits(lists) {
  let [lo, hi] = [Infinity, -Infinity];
  for (const values of lists) {
    for (const x of values) {
      if (x < lo) lo = x;
      if (x > hi) hi = x;
    }
  }
  return lo <= hi ? [lo, hi] : [0, 1];
}
