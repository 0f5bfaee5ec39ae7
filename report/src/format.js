// Numbers as people read them.

const MINUS = "\u2212";
const NARROW = "\u202f";

/** To so many figures; as a power of ten where it is very large or small. */
export function short(x, figures = 4) {
  if (x === null || x === undefined || Number.isNaN(x)) return "unknown";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e-3 && size < 1e6) {
    const digits = Math.max(0, figures - 1 - Math.floor(Math.log10(size)));
    return grouped(x.toFixed(Math.min(digits, 12)));
  }
  const [mantissa, exponent] = x.toExponential(figures - 1).split("e");
  return `${mantissa.replace("-", MINUS)}·10${superscript(Number(exponent))}`;
}

const DIGITS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
export const superscript = (n) => (n < 0 ? "⁻" : "") + [...String(Math.abs(n))].map((d) => DIGITS[d]).join("");

function grouped(text) {
  const [whole, rest] = text.replace("-", MINUS).split(".");
  const parts = whole.replace(/\B(?=(\d{3})+(?!\d))/g, NARROW);
  return rest ? `${parts}.${rest}` : parts;
}

/** As given: no more figures than it has, up to eight. */
export function plain(x) {
  const size = Math.abs(x);
  if (x !== 0 && (size < 1e-4 || size >= 1e9)) {
    const [mantissa, exponent] = Number(x.toPrecision(8)).toExponential().split("e");
    const power = `10${superscript(Number(exponent))}`;
    return mantissa === "1" ? power : `${mantissa.replace("-", MINUS)}·${power}`;
  }
  return grouped(String(Number(x.toPrecision(8))));
}

export const count = (n) => grouped(String(n));
export const percent = (x) => (x === null || x === undefined ? "unknown" : `${short(100 * x, 3)}${NARROW}%`);
export const seconds = (s) => (s >= 100 ? `${short(s, 3)} s` : s >= 1 ? `${s.toFixed(1)} s` : `${Math.round(1000 * s)} ms`);
export const bytes = (b) => (b >= 1e9 ? `${(b / 1e9).toFixed(2)} GB` : `${Math.round(b / 1e6)} MB`);
export const vector = (v, figures = 4) => `(${v.map((x) => short(x, figures)).join(", ")})`;
export const plural = (n, one, many = `${one}s`) => `${count(n)} ${n === 1 ? one : many}`;
export const withUnit = (text, unit) => (unit ? `${text}${NARROW}${unit}` : text);
/** Components that are rounding beside the largest of `scale` as zero. */
export const cleaned = (v, scale = Math.max(...v.map(Math.abs))) => v.map((x) => (Math.abs(x) < 1e-6 * scale ? 0 : x));
export const list = (words) => (words.length < 2 ? words.join("") : `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`);
