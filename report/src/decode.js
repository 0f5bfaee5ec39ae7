// The arrays of a step, from the text in the page.

const UNKNOWN = 65535;

function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function inflated(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function values(bytes, at, { rows, width, limits }) {
  const out = new Float64Array(rows * width);
  for (let c = 0; c < width; c++) {
    const [lo, hi] = limits[c];
    let code = 0;
    for (let i = 0; i < rows; i++) {
      code = (code + bytes[at + i] + (bytes[at + rows + i] << 8)) & 0xffff;
      out[i * width + c] = code === UNKNOWN ? NaN : lo + (hi - lo) * (code / 65534);
    }
    at += 2 * rows;
  }
  return out;
}

function indices(bytes, at, { rows, width }) {
  const out = new Uint32Array(rows * width);
  for (let c = 0; c < width; c++) {
    let last = 0;
    for (let i = 0; i < rows; i++) {
      const z = (bytes[at + i] | (bytes[at + rows + i] << 8) | (bytes[at + 2 * rows + i] << 16) | (bytes[at + 3 * rows + i] << 24)) >>> 0;
      last = (last + ((z >>> 1) ^ -(z & 1))) | 0;
      out[i * width + c] = last >>> 0;
    }
    at += 4 * rows;
  }
  return out;
}

/** All arrays of a step by name; `limits` has the limits of those that were made codes. */
export async function decode(text, sections) {
  const bytes = await inflated(text);
  const arrays = { limits: {} };
  let at = 0;
  for (const section of sections) {
    const { name, kind, rows, width } = section;
    if (kind === "q16") {
      arrays[name] = values(bytes, at, section);
      arrays.limits[name] = section.limits;
      at += 2 * rows * width;
    } else if (kind === "u32") {
      arrays[name] = indices(bytes, at, section);
      at += 4 * rows * width;
    } else {
      arrays[name] = bytes.subarray(at, at + rows);
      at += rows;
    }
  }
  return arrays;
}
