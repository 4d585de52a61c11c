/** Lattice clouds, and their points as the daemon makes them. */

import { NdArray } from './ndarray.js';
import type { Lattice } from './types.js';

/** A lattice cloud on the box from lower to upper with `cells` cells per side. */
export function lattice(
  lower: number[],
  upper: number[],
  cells: number[],
  options: { jitter?: number; seed?: number } = {},
): { lattice: Lattice } {
  return { lattice: { lower, upper, cells, ...options } };
}

/** Number of points of a lattice. */
export function latticeCount({ cells }: Lattice): number {
  return cells.reduce((count, side) => count * (side + 1), 1);
}

/** Points [n][d] of a lattice, x fastest, displaced exactly as the daemon displaces them. */
export function latticePoints(box: Lattice): NdArray {
  const dim = box.cells.length;
  const count = latticeCount(box);
  const data = new Float64Array(count * dim);
  const chi = box.jitter ? uniform(BigInt(box.seed ?? 0)) : undefined;
  const place = new Array<number>(dim).fill(0);
  for (let p = 0; p < count; p++, advance(place, box.cells)) {
    const moves = chi && place.every((i, k) => i > 0 && i < (box.cells[k] ?? 0));
    for (let k = 0; k < dim; k++) {
      data[p * dim + k] = coordinate(box, k, place[k] ?? 0);
      if (moves) data[p * dim + k]! += (box.jitter ?? 0) * (chi() - 0.5) * step(box, k);
    }
  }
  return new NdArray(data, [count, dim]);
}

function advance(place: number[], cells: number[]): void {
  for (let k = 0; k < place.length; k++) {
    place[k]!++;
    if (place[k]! <= cells[k]!) return;
    place[k] = 0;
  }
}

function coordinate({ lower, upper, cells }: Lattice, k: number, i: number): number {
  if (i === cells[k]) return upper[k]!;
  return lower[k]! + ((upper[k]! - lower[k]!) * i) / cells[k]!;
}

function step({ lower, upper, cells }: Lattice, k: number): number {
  return (upper[k]! - lower[k]!) / cells[k]!;
}

const mask = (1n << 64n) - 1n;

/** SplitMix64 (Steele, Lea and Flood 2014) as numbers in [0, 1). */
function uniform(seed: bigint): () => number {
  let state = seed;
  return () => {
    state = (state + 0x9e3779b97f4a7c15n) & mask;
    let z = ((state ^ (state >> 30n)) * 0xbf58476d1ce4e5b9n) & mask;
    z = ((z ^ (z >> 27n)) * 0x94d049bb133111ebn) & mask;
    z ^= z >> 31n;
    return Number(z >> 11n) * 2 ** -53;
  };
}
