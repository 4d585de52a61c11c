/** Arrays with a shape: what RFC 8746 calls a multi-dimensional array (tag 40, row-major). */

export type Numbers =
  | Float64Array
  | Float32Array
  | Int32Array
  | Uint32Array
  | Int16Array
  | Uint16Array
  | Int8Array;

/** Numbers in row-major order with their shape: points of n rows and d columns have shape [n, d]. */
export class NdArray {
  constructor(
    readonly data: Numbers,
    readonly shape: readonly number[],
  ) {
    const size = shape.reduce((product, side) => product * side, 1);
    if (size !== data.length) {
      throw new RangeError(`shape ${shape.join(' x ')} needs ${size} numbers, got ${data.length}`);
    }
  }

  /** Number of rows. */
  get length(): number {
    return this.shape[0] ?? 0;
  }

  /** Numbers per row. */
  get stride(): number {
    return this.shape.slice(1).reduce((product, side) => product * side, 1);
  }

  /** Row k; shares memory with the whole. */
  row(k: number): Numbers {
    return this.data.subarray(k * this.stride, (k + 1) * this.stride);
  }

  /** Column k of a matrix, copied. */
  column(k: number): Float64Array {
    const { length, stride, data } = this;
    return Float64Array.from({ length }, (_, row) => data[row * stride + k] as number);
  }

  /** Nested plain arrays, as JSON has them. */
  toJSON(): unknown {
    return nested(this.data, this.shape, 0);
  }

  /** From nested plain arrays whose rows are equally long. */
  static from(rows: readonly (readonly number[])[]): NdArray {
    const width = rows[0]?.length ?? 0;
    const data = new Float64Array(rows.length * width);
    rows.forEach((row, k) => {
      if (row.length !== width) {
        throw new RangeError(`row ${k} has ${row.length} numbers, needs ${width} like the first`);
      }
      data.set(row, k * width);
    });
    return new NdArray(data, [rows.length, width]);
  }
}

function nested(data: Numbers, shape: readonly number[], from: number): unknown {
  const [rows = 0, ...rest] = shape;
  if (rest.length === 0) return Array.from(data.subarray(from, from + rows));
  const step = rest.reduce((product, side) => product * side, 1);
  return Array.from({ length: rows }, (_, k) => nested(data, rest, from + k * step));
}

/** Bytes (Uint8Array) are no numbers: CBOR has byte strings for them. */
export function isNumbers(value: unknown): value is Numbers {
  return ArrayBuffer.isView(value) && !(value instanceof DataView) && !(value instanceof Uint8Array);
}
