/** The catalogue: problems that are known to be interesting, as requests one can edit. */

import type { Request } from './request.js';

export interface Case extends Request {
  id: string;
  title: string;
  about: string;
  /** Case of process `study` with the same problem. */
  study?: string;
  /** A picture for the card: value in [0, 1] by place in the box [0, 1] x [0, 1]. */
  sketch: (x: number, y: number) => number;
}

const gartland =
  'sin(pi*y) * (2*(exp((l + b)*(x - 1)) - exp(-c*x - (l + b))) + exp(-c*x) - exp((l + b)*(x - 1) - c)) / -expm1(-2*l)';

const wall = { type: 'dirichlet', value: '1 - tanh(10)' };

export const cases: Case[] = [
  {
    id: 'smith-hutton',
    title: 'A front carried round a bend',
    about: 'Smith and Hutton: a steep inlet profile turns through half a circle, hardly diffused.',
    study: 'smith-hutton',
    sketch: (x, y) => {
      const a = 2 * x - 1;
      const psi = (1 - a * a) * (1 - y * y);
      return (1 + Math.tanh(10 * (1 - 2 * Math.sqrt(1 - psi)))) / 2;
    },
    process: 'solve',
    inputs: {
      cloud: { lattice: { lower: [-1, 0], upper: [1, 1], cells: [80, 40], jitter: 0.2, seed: 1 } },
      velocity: ['2*y*(1 - x^2)', '-2*x*(1 - y^2)'],
      diffusivity: 0.002,
      boundary: [
        { on: 'bottom', type: 'neumann', value: 0 },
        { on: Array.from({ length: 41 }, (_, k) => k), type: 'dirichlet', value: '1 + tanh(10*(2*x + 1))' },
        { on: 'left', ...wall },
        { on: 'right', ...wall },
        { on: 'top', ...wall },
      ],
      operator: { scheme: 'lsmps' },
    },
  },
  {
    id: 'gartland',
    title: 'A boundary layer',
    about: 'Gartland: convection against a wall, a layer as thin as the diffusivity, exact solution known.',
    study: 'gartland',
    sketch: (x, y) => Math.sin(Math.PI * y) * (0.5 * Math.exp(-0.2 * x) + 0.5 * Math.exp(14 * (x - 1))),
    process: 'solve',
    inputs: {
      cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [60, 60], jitter: 0, seed: 0 } },
      parameters: { b: 50, l: 50.09859882672458, c: 0.09859882672457894 },
      velocity: [1, 0],
      diffusivity: 0.01,
      boundary: [{ on: 'boundary', type: 'dirichlet', value: gartland }],
      exact: gartland,
      operator: { scheme: 'mps', kernel: 'center', radius: 2, number_density: 'reference', upwind: 'none' },
    },
  },
  {
    id: 'skew',
    title: 'A discontinuity across the lattice',
    about: 'A jump carried at 45 degrees: upwinding keeps it within bounds where central differences ring.',
    study: 'skew',
    sketch: (x, y) => 0.5 + 0.5 * Math.tanh(30 * (y - x)),
    process: 'solve',
    inputs: {
      cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [40, 40], jitter: 0, seed: 0 } },
      parameters: { u: 0.7071067811865476, v: 0.7071067811865476 },
      velocity: ['u', 'v'],
      diffusivity: 0.001,
      boundary: [{ on: 'boundary', type: 'dirichlet', value: 'u*y - v*x > 1e-12' }],
      operator: { scheme: 'mps', kernel: 'center', radius: 2, number_density: 'reference', upwind: 'published' },
    },
  },
  {
    id: 'heat',
    title: 'Heat on a jittered cloud',
    about: 'The heat equation in time, from a known decay; every saved time can be looked at.',
    study: 'diffusion-2d',
    sketch: (x, y) => 0.5 + 0.5 * Math.sin(2 * Math.PI * x) * Math.sin(Math.PI * y),
    process: 'solve',
    inputs: {
      cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [48, 48], jitter: 0.5, seed: 7 } },
      diffusivity: 1,
      initial: 'sin(2*pi*x) * sin(pi*y)',
      time: {
        method: 'crank-nicolson',
        end: 0.05,
        step: 0.0005,
        save: [0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.035, 0.04, 0.045, 0.05],
      },
      boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }],
      exact: 'sin(2*pi*x) * sin(pi*y) * exp(-5*pi^2*t)',
    },
  },
  {
    id: 'cavity',
    title: 'Flow in a lid-driven cavity',
    about: 'Incompressible flow under a moving lid at Reynolds number 100, as moving particles.',
    study: 'cavity',
    sketch: (x, y) => {
      const psi = 16 * x * x * (1 - x) ** 2 * y ** 2 * (1 - y) * 4.5;
      return Math.min(1, 0.08 + 1.1 * psi + 0.9 * y ** 14);
    },
    process: 'flow',
    inputs: { case: 'cavity', cells: 24, reynolds: 100, end: 6, save: [0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6] },
  },
  {
    id: 'step',
    title: 'Flow over a backward-facing step',
    about: 'A channel that widens suddenly: the stream separates and comes back to the wall.',
    study: 'step',
    sketch: (x, y) => {
      const floor = x < 0.25 ? 0.5 : 0;
      if (y < floor) return NaN;
      const width = 0.5 + 0.5 * Math.min(1, Math.max(0, (x - 0.25) * 1.4));
      const s = (y - (1 - width)) / width;
      return s < 0 ? 0.06 : Math.max(0.06, (4 * s * (1 - s) * 0.5) / width);
    },
    process: 'flow',
    inputs: { case: 'step', cells: 9, reynolds: 100, end: 12, save: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12] },
  },
];

export function caseOf(id: string | null): Case | undefined {
  return cases.find((one) => one.id === id);
}

// ---- Problems of one's own ----

const starts: Record<string, Request['inputs']> = {
  solve: {
    cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [40, 40], jitter: 0.2, seed: 1 } },
    diffusivity: 1,
    source: 1,
    boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }],
  },
  apply: { cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [40, 40], jitter: 0.2, seed: 1 } }, field: 'sin(3*x) * cos(2*y)' },
  diagnose: { cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [40, 40], jitter: 0.5, seed: 1 } } },
  study: { case: 'gartland' },
  flow: { case: 'cavity', cells: 24, reynolds: 100, end: 6 },
  echo: { message: 'hello' },
  batch: {
    cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [40, 40], jitter: 0.2, seed: 1 } },
    requests: [
      { process: 'solve', inputs: { diffusivity: 1, source: 1, boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }] } },
      { process: 'diagnose', inputs: {} },
    ],
  },
};

/** The inputs with which a problem of one's own begins. */
export function startOf(process: string): Request['inputs'] {
  return structuredClone(starts[process] ?? {});
}
