/**
 * Packets: records with arrays as bytes, as mgjax/stage/packet.py writes and reads them.
 *
 * `MGS1`, the length of a header (32-bit, little-endian), the header (JSON, padded to four bytes)
 * and the arrays, each at a multiple of four. An array in the value is `{"$array": number}`.
 */

const MAGIC = 'MGS1';
const TYPES = {
  int8: Int8Array, uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array,
  int32: Int32Array, uint32: Uint32Array, float32: Float32Array,
};

const padded = (size) => Math.ceil(size / 4) * 4;

/**
 * The value of a packet; typed arrays carry their `shape`.
 * @param {ArrayBuffer} buffer
 * @returns {*}
 * @throws {Error} where the bytes are no packet
 */
export function unpack(buffer) {
  const head = new Uint8Array(buffer, 0, Math.min(8, buffer.byteLength));
  if (head.length < 8 || String.fromCharCode(...head.subarray(0, 4)) !== MAGIC) {
    throw new Error('these bytes are no packet');
  }
  const length = new DataView(buffer).getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const arrays = header.arrays.map((entry) => arrayAt(buffer, 8 + length, entry));
  return withArrays(header.value, arrays);
}

function arrayAt(buffer, base, { type, shape, at }) {
  if (!Object.hasOwn(TYPES, type)) throw new Error(`a packet cannot have an array of ${type}`);
  const count = shape.reduce((product, size) => product * size, 1);
  const array = new TYPES[type](buffer, base + at, count);
  array.shape = shape;
  return array;
}

function withArrays(value, arrays) {
  if (Array.isArray(value)) return value.map((item) => withArrays(item, arrays));
  if (value === null || typeof value !== 'object') return value;
  const names = Object.keys(value);
  if (names.length === 1 && names[0] === '$array') return arrays[value.$array];
  return Object.fromEntries(names.map((name) => [name, withArrays(value[name], arrays)]));
}

/**
 * A packet of a value of records, lists, strings, finite numbers, null and typed arrays; an array
 * without a `shape` has one axis.
 * @param {*} value
 * @returns {ArrayBuffer}
 */
export function pack(value) {
  const arrays = [];
  const plain = withoutArrays(value, arrays);
  let size = 0;
  const entries = arrays.map((array) => {
    const entry = { type: typeName(array), shape: array.shape ?? [array.length], at: size };
    size += padded(array.byteLength);
    return entry;
  });
  const text = new TextEncoder().encode(JSON.stringify({ value: plain, arrays: entries }));
  const length = padded(text.length);
  const bytes = new Uint8Array(8 + length + size);
  bytes.set(new TextEncoder().encode(MAGIC));
  new DataView(bytes.buffer).setUint32(4, length, true);
  bytes.fill(0x20, 8, 8 + length);
  bytes.set(text, 8);
  arrays.forEach((array, i) => {
    const part = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
    bytes.set(part, 8 + length + entries[i].at);
  });
  return bytes.buffer;
}

function withoutArrays(value, arrays) {
  if (ArrayBuffer.isView(value)) {
    arrays.push(value);
    return { $array: arrays.length - 1 };
  }
  if (Array.isArray(value)) return value.map((item) => withoutArrays(item, arrays));
  if (typeof value === 'number' && !Number.isFinite(value)) {
    throw new Error(`got ${value}, expected a finite number`);
  }
  if (value === null || typeof value !== 'object') return value;
  const names = Object.keys(value);
  return Object.fromEntries(names.map((name) => [name, withoutArrays(value[name], arrays)]));
}

function typeName(array) {
  const found = Object.entries(TYPES).find(([, type]) => array instanceof type);
  if (!found) throw new Error(`a packet cannot have a ${array.constructor.name}`);
  return found[0];
}
