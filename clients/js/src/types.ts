/** What requests and results look like; the daemon's own description is at /api. */

import type { NdArray, Numbers } from './ndarray.js';

/** A number, an expression of x, y, z, t, or one value per point. */
export type ScalarField = number | string | readonly number[] | Numbers;
export type VectorField = readonly (number | string)[] | readonly (readonly number[])[] | NdArray;
export type Points = readonly (readonly number[])[] | NdArray | Numbers;

export interface Lattice {
  lower: number[];
  upper: number[];
  cells: number[];
  jitter?: number;
  seed?: number;
}

export type Cloud =
  | { lattice: Lattice }
  | { href: string }
  | {
      points: Points;
      spacing?: number;
      groups?: Record<string, readonly number[] | Numbers>;
      normals?: Record<string, readonly number[] | NdArray>;
    };

export interface BoundaryEntry {
  on: string | readonly number[] | Numbers;
  type: 'dirichlet' | 'neumann' | 'robin';
  value: ScalarField;
  normal?: readonly number[] | NdArray;
  coefficient?: ScalarField;
}

export interface Operator {
  scheme?: 'mps' | 'ps' | 'ips' | 'ipsn' | 'lsmps';
  degree?: number;
  weight?: 'kernel/r2' | 'kernel';
  kernel?: string;
  radius?: number;
  number_density?: 'local' | 'reference';
  upwind?: string;
  [member: string]: unknown;
}

export interface Time {
  method?: 'forward-euler' | 'backward-euler' | 'crank-nicolson' | 'bdf2';
  start?: number;
  end: number;
  step?: number;
  diffusion_number?: number;
  save?: readonly number[];
}

export interface SolveInputs {
  cloud: Cloud;
  parameters?: Record<string, number>;
  velocity?: VectorField;
  diffusivity: ScalarField;
  source?: ScalarField;
  reaction?: ScalarField;
  boundary?: readonly BoundaryEntry[];
  operator?: Operator;
  solver?: Record<string, unknown>;
  time?: Time;
  initial?: ScalarField;
  exact?: ScalarField;
}

export interface Norms {
  l1: number;
  l2: number;
  linf: number;
  l2_relative: number;
  linf_all: number;
  points: number;
}

/** Results: arrays are typed when they came as CBOR, and plain when they came as JSON. */
export interface SolveResult {
  solution: Numbers;
  points: NdArray;
  norms?: Norms;
  diagnostics: Record<string, unknown>;
  history?: { t: Numbers; solution: NdArray; l2?: Numbers; linf?: Numbers; steps?: number };
  report: { version: string; threads: number; seconds: Record<string, number>; memory_peak_bytes: number };
}

export type JobStatus = 'accepted' | 'running' | 'successful' | 'failed' | 'dismissed';

export interface Link {
  href: string;
  rel?: string;
  type?: string;
  title?: string;
}

export interface StatusInfo {
  jobID: string;
  status: JobStatus;
  type?: string;
  processID?: string;
  message?: string;
  progress?: number;
  created?: string;
  started?: string;
  finished?: string;
  updated?: string;
  /** Of a batch: how many requests it has. */
  parts?: number;
  links?: Link[];
}

/** JSON Schema as the process descriptions have it. */
export interface Schema {
  title?: string;
  description?: string;
  type?: string;
  enum?: unknown[];
  default?: unknown;
  properties?: Record<string, Schema>;
  additionalProperties?: boolean | Schema;
  required?: string[];
  items?: Schema;
  oneOf?: Schema[];
  anyOf?: Schema[];
  allOf?: Schema[];
  minimum?: number;
  maximum?: number;
  minItems?: number;
  maxItems?: number;
  exclusiveMinimum?: boolean;
  exclusiveMaximum?: boolean;
}

export interface PartDescription {
  title: string;
  description: string;
  schema: Schema;
  minOccurs?: number;
}

export interface ProcessSummary {
  id: string;
  title: string;
  description: string;
  version: string;
  keywords?: string[];
  jobControlOptions?: string[];
  links: Link[];
}

export interface ProcessDescription extends ProcessSummary {
  inputs: Record<string, PartDescription>;
  outputs: Record<string, PartDescription>;
}
