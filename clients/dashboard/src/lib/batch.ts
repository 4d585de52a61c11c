/** Batches: requests out of pasted text, and the request that a part of a batch was. */

import type { Request } from './request';

/** A request within a batch; without a process it is a solve. */
export interface Part {
  process?: string;
  inputs: Record<string, unknown>;
  [member: string]: unknown;
}

/** A list of requests, or one with a table of parameter values; `cloud` is for those without one. */
export interface BatchInputs {
  requests?: Part[];
  request?: Part;
  parameters?: Record<string, number[]>;
  cloud?: unknown;
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/** One JSON document, or one on every line. */
function documentsOf(text: string): unknown[] {
  try {
    return [JSON.parse(text)];
  } catch (error) {
    const lines = text.split('\n').map((line) => line.trim()).filter(Boolean);
    try {
      if (lines.length > 1) return lines.map((line) => JSON.parse(line));
    } catch {
      /* then it was meant as one document, and that is what to complain about */
    }
    throw error;
  }
}

function partsOf(value: unknown): unknown[] {
  if (Array.isArray(value)) return value.flatMap(partsOf);
  if (isObject(value) && Array.isArray(value.requests)) return partsOf(value.requests);
  if (isObject(value) && isObject(value.inputs) && Array.isArray(value.inputs.requests)) return partsOf(value.inputs.requests);
  return [value];
}

/** Requests of a text: a list, one, one per line, or a whole batch. Throws what is wrong with it. */
export function parseRequests(text: string): Part[] {
  return documentsOf(text).flatMap(partsOf).map((part, k) => {
    if (isObject(part) && isObject(part.inputs)) return part as Part;
    throw new Error(`number ${k + 1} is no request: it has no member "inputs" that is an object`);
  });
}

/** How many jobs a batch is made of; undefined where columns of its table differ in length. */
export function lengthOf({ requests, parameters }: BatchInputs): number | undefined {
  if (requests) return requests.length;
  const lengths = new Set(Object.values(parameters ?? {}).map((column) => column.length));
  return lengths.size > 1 ? undefined : ([...lengths][0] ?? 0);
}

/** What part k of a batch was asked, with the cloud and the row of the table that are its own. */
export function partOf(batch: Request | undefined, k: number): Request | undefined {
  const { requests, request, parameters, cloud } = (batch?.inputs ?? {}) as BatchInputs;
  const part = requests?.[k] ?? request;
  if (!part) return undefined;
  const row = Object.entries(parameters ?? {}).map(([name, column]) => [name, column[k]]);
  const own = part.inputs.parameters as object | undefined;
  return {
    process: part.process ?? 'solve',
    inputs: {
      ...(cloud !== undefined && { cloud }),
      ...part.inputs,
      ...(row.length > 0 && { parameters: { ...own, ...Object.fromEntries(row) } }),
    },
  };
}

/** The values of a request that fit a line, to tell it from others. */
export function inShort(inputs: Record<string, unknown>): string {
  const plain = Object.entries(inputs).filter(([, value]) => ['number', 'string', 'boolean'].includes(typeof value));
  return plain.map(([name, value]) => `${name.replaceAll('_', ' ')} ${String(value)}`).join(', ').slice(0, 120);
}
