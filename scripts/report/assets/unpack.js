// Reads what packing.py packs: JSON with arrays in it.

const TYPES = { b: Int8Array, h: Int16Array, i: Int32Array, B: Uint8Array, H: Uint16Array, f: Float32Array };

/** The value in an ArrayBuffer. Series become Float64Array of values in their own unit. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 4, length));
  return JSON.parse(text, (key, value) =>
    value !== null && typeof value === "object" && Array.isArray(value.$)
      ? array(buffer, 4 + length, value)
      : value,
  );
}

function array(buffer, base, { $: [offset, type, count], delta, step }) {
  const stored = new TYPES[type](buffer, base + offset, count);
  if (!delta) return stored;
  const values = new Float64Array(count);
  let sum = 0;
  for (let i = 0; i < count; i++) {
    sum += stored[i];
    values[i] = sum * step;
  }
  return values;
}

export function fromBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** The bytes that gzip packed, as an ArrayBuffer. */
export async function unzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}
