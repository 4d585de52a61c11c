/** Colour maps: perceptually uniform ones for magnitudes, a diverging one for what has a sign. */

import {
  interpolateCividis,
  interpolateMagma,
  interpolateRdBu,
  interpolateViridis,
} from 'd3-scale-chromatic';

export const maps: Record<string, { label: string; at: (t: number) => string }> = {
  viridis: { label: 'Viridis', at: interpolateViridis },
  magma: { label: 'Magma', at: interpolateMagma },
  cividis: { label: 'Cividis', at: interpolateCividis },
  diverging: { label: 'Blue to red', at: (t) => interpolateRdBu(1 - t) },
};

/** 256 RGBA colours of a map, for a texture. */
export function table(name: string): Uint8Array {
  const { at } = maps[name] ?? maps.viridis!;
  const bytes = new Uint8Array(256 * 4);
  for (let k = 0; k < 256; k++) bytes.set([...rgb(at(k / 255)), 255], 4 * k);
  return bytes;
}

function rgb(text: string): number[] {
  if (text.startsWith('#')) return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
  return (text.match(/[0-9.]+/g) ?? []).slice(0, 3).map(Number);
}
