/** Clouds out of files: CSV, .npy, JSON. */

import { NdArray } from 'scatterd';

export interface CloudValue {
  points: NdArray;
  groups?: Record<string, number[]>;
  [member: string]: unknown;
}

export async function readCloud(file: File): Promise<CloudValue> {
  const name = file.name.toLowerCase();
  const cloud = name.endsWith('.npy')
    ? { points: readNpy(await file.arrayBuffer()) }
    : name.endsWith('.json')
      ? readJson(await file.text())
      : readCsv(await file.text());
  check(cloud.points);
  return cloud;
}

function check({ shape, data }: NdArray): void {
  const [rows = 0, columns = 0] = shape;
  if (shape.length !== 2 || columns < 1 || columns > 3) {
    throw new Error(`the points are ${shape.join(' x ')}, need n rows of 1, 2 or 3 coordinates`);
  }
  if (rows === 0) throw new Error('there are no points in it');
  const bad = (data as Float64Array).findIndex((value) => !Number.isFinite(value));
  if (bad >= 0) throw new Error(`point ${Math.floor(bad / columns)} has a coordinate that is no number`);
}

/** Bare points, a cloud, or a whole request. */
export function readJson(text: string): CloudValue {
  const value = JSON.parse(text);
  const cloud = value?.inputs?.cloud?.value ?? value?.inputs?.cloud ?? value?.cloud ?? value;
  const rows: unknown = Array.isArray(cloud) ? cloud : cloud?.points;
  if (!Array.isArray(rows)) throw new Error('it has no "points"');
  const points = NdArray.from(rows.map((row) => (Array.isArray(row) ? row : [row])));
  return Array.isArray(cloud) ? { points } : { ...cloud, points };
}

/** Columns x, y, z, and "group" for a point's group; without a header, the first two or three. */
export function readCsv(text: string): CloudValue {
  const lines = text.split(/\r?\n/).map((line) => line.trim()).filter((line) => line && !line.startsWith('#'));
  const split = (line: string): string[] => line.split(/[,;\t]\s*|\s+/).map((cell) => cell.trim());
  const first = split(lines[0] ?? '');
  const headed = first.some((cell) => cell && Number.isNaN(Number(cell)) && cell !== 'nan');
  const names = headed ? first.map((cell) => cell.replace(/"/g, '').toLowerCase()) : first.map((_, k) => 'xyz'[k] ?? '');
  const axes = ['x', 'y', 'z'].map((axis) => names.indexOf(axis)).filter((k) => k >= 0);
  if (axes.length === 0) throw new Error('its first line names no column x');
  const rows = lines.slice(headed ? 1 : 0).map(split);
  const points = NdArray.from(rows.map((row) => axes.map((k) => Number(row[k] || NaN))));
  const groups = groupsOf(rows, names.indexOf('group'));
  return groups ? { points, groups } : { points };
}

function groupsOf(rows: string[][], column: number): Record<string, number[]> | undefined {
  if (column < 0) return undefined;
  const groups: Record<string, number[]> = {};
  rows.forEach((row, k) => {
    const name = row[column]?.replace(/"/g, '');
    if (name) (groups[name] ??= []).push(k);
  });
  return groups;
}

/** The .npy format of numpy, versions 1 to 3: magic, header as a Python literal, numbers. */
export function readNpy(buffer: ArrayBuffer): NdArray {
  const view = new DataView(buffer);
  if (buffer.byteLength < 12 || view.getUint32(0) !== 0x934e554d) throw new Error('it is not an .npy file');
  const long = view.getUint8(6) > 1;
  const start = long ? 12 : 10;
  const length = long ? view.getUint32(8, true) : view.getUint16(8, true);
  const header = new TextDecoder().decode(new Uint8Array(buffer, start, length));
  const type = /'descr':\s*'([^']+)'/.exec(header)?.[1] ?? '';
  const shape = (/'shape':\s*\(([^)]*)\)/.exec(header)?.[1] ?? '').split(',').filter((part) => part.trim()).map(Number);
  if (/'fortran_order':\s*True/.test(header)) throw new Error('it is in Fortran order; save numpy.ascontiguousarray(points)');
  const data = numbersOf(type, buffer.slice(start + length));
  return new NdArray(data, shape.length === 1 ? [shape[0]!, 1] : shape);
}

function numbersOf(type: string, bytes: ArrayBuffer): Float64Array {
  const kinds = { '<f8': Float64Array, '<f4': Float32Array, '<i4': Int32Array, '<i8': BigInt64Array };
  const Kind = kinds[type as keyof typeof kinds];
  if (!Kind) throw new Error(`its numbers are ${type}, need ${Object.keys(kinds).join(', ')}`);
  return Float64Array.from(new Kind(bytes) as ArrayLike<number | bigint>, Number);
}
