/** How a scene is looked at: all of it fits into a link. */

import type { Camera } from '../picture/camera';
import type { Cut } from '../picture/overlay';

export interface Look {
  field: string;
  map: string; // "" is the field's own
  range: [number, number] | undefined; // undefined: that of the values
  step: number;
  arrows: string; // vector field, "" for none
  motion: string;
  cells: boolean;
  size: number;
  opened: number; // in space: how much of the front is hidden
  cut: Cut | undefined;
  camera: Camera | undefined;
}

export const firstLook: Look = {
  field: '', map: '', range: undefined, step: -1, arrows: '', motion: '', cells: true, size: 1, opened: 0, cut: undefined, camera: undefined,
};

const digits = (value: number): string => String(Number(value.toPrecision(7)));
const list = (values: number[]): string => values.map(digits).join(',');
const numbers = (text: string): number[] => text.split(',').map(Number);

/** Only what differs from the first look is written. */
export function writeLook(look: Look, query: URLSearchParams): void {
  const { camera, cut, range } = look;
  const entries: [string, string | undefined][] = [
    ['field', look.field || undefined],
    ['map', look.map || undefined],
    ['range', range && list(range)],
    ['step', look.step >= 0 ? String(look.step) : undefined],
    ['arrows', look.arrows || undefined],
    ['motion', look.motion || undefined],
    ['cells', look.cells ? undefined : '0'],
    ['size', look.size === 1 ? undefined : digits(look.size)],
    ['opened', look.opened ? digits(look.opened) : undefined],
    ['cut', cut && list([...cut.from, ...cut.to])],
    ['camera', camera && list([...camera.centre, camera.zoom, camera.yaw, camera.pitch])],
  ];
  for (const [name, value] of entries) if (value !== undefined) query.set(name, value);
}

export function readLook(query: URLSearchParams): Look {
  const get = (name: string): string => query.get(name) ?? '';
  const several = (name: string, count: number): number[] | undefined => {
    const values = numbers(get(name));
    return values.length === count && values.every(Number.isFinite) ? values : undefined;
  };
  const [range, cut, camera] = [several('range', 2), several('cut', 4), several('camera', 6)];
  return {
    field: get('field'),
    map: get('map'),
    range: range && [range[0]!, range[1]!],
    step: query.has('step') ? Number(get('step')) : -1,
    arrows: get('arrows'),
    motion: get('motion'),
    cells: get('cells') !== '0',
    size: Number(get('size')) || 1,
    opened: Number(get('opened')) || 0,
    cut: cut && { from: [cut[0]!, cut[1]!], to: [cut[2]!, cut[3]!] },
    camera: camera && { centre: [camera[0]!, camera[1]!, camera[2]!], zoom: camera[3]!, yaw: camera[4]!, pitch: camera[5]! },
  };
}
