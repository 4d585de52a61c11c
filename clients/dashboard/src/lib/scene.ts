/** What a result has to show: points, and fields and vectors on them. Fields that cost something
 *  (an expression at every point, another request) are made when they are asked for, and kept. */

import { isNumbers, latticePoints, NdArray, type Lattice, type Numbers } from 'scatterd';
import { compile } from './expression';
import { client } from './daemon';
import type { Request } from './request';

export type Result = Record<string, unknown>;

export interface Field {
  id: string;
  label: string;
  /** Values have a sign that matters: a diverging map, symmetric about zero. */
  signed?: boolean;
  /** Values [n] at saved time number `step`. */
  values: (step: number) => Promise<Float64Array>;
}

export interface VectorField {
  id: string;
  label: string;
  /** Vectors [n][d], row-major. */
  values: () => Promise<Float64Array>;
}

export interface Scene {
  dim: number;
  count: number;
  /** Coordinates [n][d]. */
  points: Float64Array;
  lower: number[];
  upper: number[];
  times?: Float64Array;
  fields: Field[];
  vectors: VectorField[];
  /** The points themselves at each time, where they move. */
  snapshots?: Scene[];
}

// ---- Arrays of any origin ----

export function flat(value: unknown): Float64Array {
  if (value instanceof Float64Array) return value;
  if (value instanceof NdArray) return flat(value.data);
  if (isNumbers(value)) return Float64Array.from(value as Numbers);
  return Float64Array.from((value as number[]).flat(2));
}

export function matrix(value: unknown): NdArray {
  if (value instanceof NdArray) return value;
  if (isNumbers(value)) return new NdArray(value as Numbers, [(value as Numbers).length, 1]);
  const rows = value as number[][];
  return NdArray.from(typeof rows[0] === 'number' ? (rows as unknown as number[]).map((x) => [x]) : rows);
}

/** Keeps what a function made. */
function once<Value>(make: () => Promise<Value> | Value): () => Promise<Value> {
  let made: Promise<Value> | undefined;
  return () => {
    made ??= Promise.resolve().then(make);
    made.catch(() => (made = undefined));
    return made;
  };
}

function column(rows: Float64Array, width: number, k: number): Float64Array {
  return Float64Array.from({ length: rows.length / width }, (_, p) => rows[p * width + k]!);
}

function lengths(rows: Float64Array, width: number): Float64Array {
  return Float64Array.from({ length: rows.length / width }, (_, p) => Math.hypot(...rows.subarray(p * width, (p + 1) * width)));
}

// ---- Inputs at the points ----

type Place = Pick<Scene, 'points' | 'dim' | 'count'>;

function parametersOf({ inputs }: Request): Record<string, number> {
  const parameters = (inputs.parameters ?? {}) as Record<string, unknown>;
  return (parameters.value ?? parameters) as Record<string, number>;
}

/** A scalar field of the request at every point. */
export function evaluate(field: unknown, place: Place, parameters: Record<string, number>, t = 0): Float64Array {
  const { points, dim, count } = place;
  if (typeof field === 'number') return new Float64Array(count).fill(field);
  if (typeof field !== 'string') return flat(field);
  const at = compile(field);
  const values: Record<string, number> = { ...parameters, t };
  return Float64Array.from({ length: count }, (_, p) => {
    for (let k = 0; k < dim; k++) values['xyz'[k]!] = points[p * dim + k]!;
    return at(values);
  });
}

function evaluateVector(field: unknown, place: Place, parameters: Record<string, number>): Float64Array {
  const { dim, count } = place;
  if (field instanceof NdArray || isNumbers(field) || Array.isArray((field as unknown[])[0])) return flat(field);
  const parts = (field as unknown[]).map((part) => evaluate(part, place, parameters));
  const rows = new Float64Array(count * dim);
  parts.forEach((part, k) => part.forEach((value, p) => (rows[p * dim + k] = value)));
  return rows;
}

// ---- Fields by process ----

const axes = 'xyz';

/** Order of the entries of a symmetric d x d tensor in the daemon's rows. */
const tensorParts: Record<number, string[]> = { 1: ['xx'], 2: ['xx', 'yy', 'xy'], 3: ['xx', 'yy', 'zz', 'xy', 'xz', 'yz'] };

function steady(id: string, label: string, values: () => Promise<Float64Array>, signed = false): Field {
  return { id, label, signed, values };
}

function diagnosisFields(diagnosis: () => Promise<Result>, dim: number): Pick<Scene, 'fields' | 'vectors'> {
  const get = (name: string) => once(async () => flat((await diagnosis())[name]));
  const artificial = get('artificial_velocity');
  const effective = get('effective_diffusivity');
  const parts = tensorParts[dim] ?? [];
  const mean = once(async () => {
    const rows = await effective();
    const diagonal = Array.from({ length: dim }, (_, k) => column(rows, parts.length, k));
    return diagonal[0]!.map((_, p) => diagonal.reduce((sum, entry) => sum + entry[p]!, 0) / dim);
  });
  return {
    fields: [
      steady('neighbours', 'Neighbours', get('neighbours')),
      steady('number_density', 'Number density', get('number_density')),
      steady('artificial_velocity', 'Artificial velocity, size', once(async () => lengths(await artificial(), dim))),
      steady('effective_diffusivity', 'Effective diffusivity, mean', mean),
      ...parts.map((part, k) =>
        steady(`effective_${part}`, `Effective diffusivity, ${part}`, once(async () => column(await effective(), parts.length, k)))),
    ],
    vectors: [{ id: 'artificial_velocity', label: 'Artificial velocity', values: artificial }],
  };
}

function vectorFields(id: string, label: string, rows: () => Promise<Float64Array>, dim: number): Pick<Scene, 'fields' | 'vectors'> {
  const components = Array.from({ length: dim }, (_, k) =>
    steady(`${id}_${axes[k]}`, `${label}, ${axes[k]}`, once(async () => column(await rows(), dim, k)), true));
  return {
    fields: [steady(`${id}_size`, `${label}, size`, once(async () => lengths(await rows(), dim))), ...components],
    vectors: [{ id, label, values: rows }],
  };
}

function solveFields(request: Request, result: Result, place: Place, times?: Float64Array): Field[] {
  const { inputs } = request;
  const history = result.history as Result | undefined;
  const saved = times && history ? matrix(history.solution) : undefined;
  const end = Number((inputs.time as Result | undefined)?.end ?? 0);
  const solution = async (step: number): Promise<Float64Array> =>
    saved && step < saved.length ? Float64Array.from(saved.row(step)) : flat(result.solution);
  const fields: Field[] = [{ id: 'solution', label: 'Solution', values: solution }];
  if (inputs.exact === undefined) return fields;
  const exact = (step: number): Float64Array => evaluate(inputs.exact, place, parametersOf(request), times?.[step] ?? end);
  const error = async (step: number): Promise<Float64Array> => {
    const [found, right] = [await solution(step), exact(step)];
    return found.map((value, p) => value - right[p]!);
  };
  fields.push({ id: 'error', label: 'Error (solution − exact)', signed: true, values: error });
  fields.push({ id: 'exact', label: 'Exact solution', values: async (step) => exact(step) });
  return fields;
}

type Maker = (request: Request, result: Result, place: Place) => Pick<Scene, 'fields' | 'vectors'> & Partial<Scene>;

function merge(...parts: Pick<Scene, 'fields' | 'vectors'>[]): Pick<Scene, 'fields' | 'vectors'> {
  return { fields: parts.flatMap(({ fields }) => fields), vectors: parts.flatMap(({ vectors }) => vectors) };
}

function diagnosed({ inputs }: Request, dim: number): Pick<Scene, 'fields' | 'vectors'> {
  const { cloud, operator } = inputs;
  if (!cloud) return { fields: [], vectors: [] };
  const ask = once(() => client.execute('diagnose', { cloud, ...(operator ? { operator } : {}) }));
  return diagnosisFields(ask, dim);
}

const makers: Record<string, Maker | undefined> = {
  solve: (request, result, place) => {
    const history = result.history as Result | undefined;
    const times = history ? flat(history.t) : undefined;
    const velocity = request.inputs.velocity;
    const own = { fields: solveFields(request, result, place, times), vectors: [] };
    const rows = once(() => evaluateVector(velocity, place, parametersOf(request)));
    const moving = velocity === undefined ? [] : [vectorFields('velocity', 'Velocity', rows, place.dim)];
    return { ...merge(own, ...moving, diagnosed(request, place.dim)), ...(times && { times }) };
  },
  apply: (request, result, { dim }) => {
    const scalars = [['value', 'Value'], ['laplacian', 'Laplacian']].filter(([name]) => result[name!] !== undefined);
    const own = scalars.map(([name, label]) => steady(name!, label!, async () => flat(result[name!]), name === 'laplacian'));
    const gradient = result.gradient === undefined ? [] : [vectorFields('gradient', 'Gradient', async () => flat(result.gradient), dim)];
    return merge({ fields: own, vectors: [] }, ...gradient, diagnosed(request, dim));
  },
  diagnose: (_request, result, { dim }) => diagnosisFields(async () => result, dim),
  flow: (_request, result, place) => ({
    ...flowFields(result, result.mesh as Result | undefined, place), ...meshBounds(result), ...snapshotsOf(result),
  }),
};

/** Velocity and scalar of the particles, and what the mesh has, at the particles. */
function flowFields(state: Result, mesh: Result | undefined, place: Place): Pick<Scene, 'fields' | 'vectors'> {
  const own = vectorFields('velocity', 'Velocity', async () => flat(state.velocity), place.dim);
  const scalar = state.scalar === undefined ? [] : [steady('scalar', 'Scalar', async () => flat(state.scalar))];
  const onMesh = mesh
    ? [['pressure', 'Pressure, mean'], ['stream', 'Stream function, mean']].map(([name, label]) =>
        steady(name!, label!, once(() => sample(matrix(mesh[name!]), flat(mesh.x), flat(mesh.y), place)), true))
    : [];
  return { fields: [...own.fields, ...scalar, ...onMesh], vectors: own.vectors };
}

/** The box of a flow is that of its mesh: particles do not quite reach the walls. */
function meshBounds({ mesh }: Result): Partial<Scene> {
  if (!mesh) return {};
  const [x, y] = ['x', 'y'].map((axis) => flat((mesh as Result)[axis]));
  return { lower: [x![0]!, y![0]!], upper: [x!.at(-1)!, y!.at(-1)!] };
}

/** Values of the cells (or of the nodes at their lower left) that points are in. */
function sample(rows: NdArray, x: Float64Array, y: Float64Array, { points, count }: Place): Float64Array {
  const cellOf = (lines: Float64Array, value: number): number => {
    let [low, high] = [0, lines.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (lines[middle]! <= value) low = middle;
      else high = middle;
    }
    return low;
  };
  return Float64Array.from({ length: count }, (_, p) =>
    rows.data[cellOf(y, points[2 * p + 1]!) * rows.stride + cellOf(x, points[2 * p]!)]!);
}

/** The scenes at the times saved, with the end as the last. */
function snapshotsOf(result: Result): Pick<Scene, 'times' | 'snapshots'> {
  const saved = (result.snapshots ?? []) as Result[];
  if (saved.length === 0) return {};
  const mesh = result.mesh as Result | undefined;
  const snapshots = saved.map((state): Scene => {
    const rows = matrix(state.particles);
    const place = { points: flat(rows.data), dim: 2, count: rows.length };
    return { ...place, ...bounds(place), ...meshBounds(result), ...flowFields(state, mesh, place) };
  });
  return { times: Float64Array.from(saved, ({ t }) => Number(t)), snapshots };
}

/** Points of a result: its own, or those of the cloud that was asked about. */
function pointsOf({ inputs }: Request, result: Result): NdArray | undefined {
  const cloud = inputs.cloud as Record<string, unknown> | undefined;
  if (result.particles) return matrix(result.particles);
  if (result.points) return matrix(result.points);
  if (cloud?.lattice) return latticePoints(cloud.lattice as Lattice);
  return cloud?.points ? matrix(cloud.points) : undefined;
}

/** The scene of a result; undefined if it has nothing to draw. */
export function sceneOf(request: Request, result: Result): Scene | undefined {
  const maker = makers[request.process];
  const rows = maker && pointsOf(request, result);
  if (!maker || !rows || rows.length === 0) return undefined;
  const place = { points: flat(rows.data), dim: rows.shape[1] ?? 1, count: rows.length };
  return { ...place, ...bounds(place), ...maker(request, result, place) };
}

/** A scene of points alone: a cloud before anything was solved on it, coloured by group. */
export function sceneOfCloud(points: NdArray, groups: Record<string, ArrayLike<number>> = {}): Scene {
  const place = { points: flat(points.data), dim: points.shape[1] ?? 1, count: points.length };
  const member = once(() => {
    const values = new Float64Array(place.count);
    Object.values(groups).forEach((group, k) => Array.from(group).forEach((p) => (values[p] = k + 1)));
    return values;
  });
  const label = Object.keys(groups).length ? `Groups: ${Object.keys(groups).map((name, k) => `${k + 1} ${name}`).join(', ')}` : 'Points';
  return { ...place, ...bounds(place), fields: [steady('groups', label, member)], vectors: [] };
}

export function bounds({ points, dim }: Pick<Scene, 'points' | 'dim'>): { lower: number[]; upper: number[] } {
  const lower = new Array<number>(dim).fill(Infinity);
  const upper = new Array<number>(dim).fill(-Infinity);
  for (let k = 0; k < points.length; k++) {
    const axis = k % dim;
    if (points[k]! < lower[axis]!) lower[axis] = points[k]!;
    if (points[k]! > upper[axis]!) upper[axis] = points[k]!;
  }
  return { lower, upper };
}

/** Least and greatest number among values; [0, 1] if there is none. */
export function rangeOf(values: ArrayLike<number>): [number, number] {
  let [least, greatest] = [Infinity, -Infinity];
  for (let p = 0; p < values.length; p++) {
    const value = values[p]!;
    if (value < least) least = value;
    if (value > greatest) greatest = value;
  }
  return least <= greatest ? [least, greatest] : [0, 1];
}
