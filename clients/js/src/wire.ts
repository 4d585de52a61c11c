/** Bodies: CBOR (typed arrays by RFC 8746) and JSON, one data model. */

import { addExtension, Encoder } from 'cbor-x/index-no-eval';
import { isNumbers, NdArray, type Numbers } from './ndarray.js';

export type Format = 'cbor' | 'json';

export const mediaTypes: Record<Format, string> = {
  cbor: 'application/cbor',
  json: 'application/json',
};

type TaggedNdArray = [shape: ArrayLike<number>, data: Numbers | number[]];

addExtension({
  Class: NdArray as unknown as new () => NdArray,
  tag: 40,
  encode: (array: NdArray, encode: (value: unknown) => Uint8Array) =>
    encode([array.shape, array.data]),
  decode: ([shape, data]: TaggedNdArray) =>
    new NdArray(isNumbers(data) ? data : Float64Array.from(data), Array.from(shape)),
});

/* A new encoder for each body: the buffer that it keeps would hold on to the largest one. Byte
 * strings carry no tag of their own: within a browser, cbor-x would put it behind that of the array. */
const plain = { useRecords: false, mapsAsObjects: true, tagUint8Array: false };

export function encode(value: unknown, format: Format): Uint8Array | string {
  return format === 'cbor' ? new Encoder(plain).encode(value) : JSON.stringify(value, asJson);
}

/** Typed arrays as plain ones; an NdArray has its own toJSON. */
function asJson(_key: string, value: unknown): unknown {
  return isNumbers(value) ? Array.from(value) : value;
}

/** The value of a body, by its media type. */
export function decode(bytes: Uint8Array, contentType: string): unknown {
  const type = contentType.split(';')[0]?.trim() ?? '';
  if (type === mediaTypes.cbor) return new Encoder(plain).decode(bytes);
  return JSON.parse(new TextDecoder().decode(bytes));
}

/** A result document without the `value` that objects are wrapped in. */
export function unwrap(document: unknown): unknown {
  if (!isPlain(document)) return document;
  const bare = Object.entries(document).map(([name, value]) => [name, bareValue(value)]);
  return Object.fromEntries(bare);
}

function bareValue(value: unknown): unknown {
  return isPlain(value) && 'value' in value ? value.value : value;
}

function isPlain(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && Object.getPrototypeOf(value) === Object.prototype;
}
