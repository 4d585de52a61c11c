/** Values of a form: what a text means, and how a value is written. */

import { isNumbers, NdArray, type ProcessDescription, type Schema } from 'scatterd';

export type Value = unknown;

/** JSON Pointer of a member (RFC 6901). */
export function child(pointer: string, key: string | number): string {
  return `${pointer}/${String(key).replaceAll('~', '~0').replaceAll('/', '~1')}`;
}

/** A number or JSON if it reads as such, else the text itself: an expression, a name. */
export function parse(text: string): Value {
  const trimmed = text.trim();
  if (trimmed !== '' && !Number.isNaN(Number(trimmed))) return Number(trimmed);
  if (/^[[{"]/.test(trimmed)) {
    try {
      return JSON.parse(trimmed);
    } catch {
      return text;
    }
  }
  if (/^[-+0-9.eE]+(\s*,\s*[-+0-9.eE]+)+$/.test(trimmed)) return trimmed.split(',').map(Number);
  return text;
}

export function show(value: Value): string {
  if (value === undefined || value === null) return '';
  if (typeof value === 'string') return value;
  if (Array.isArray(value) && value.every((item) => typeof item === 'number')) return value.join(', ');
  return JSON.stringify(value);
}

/** Arrays too long for a line of text. */
export function isLong(value: Value): boolean {
  if (value instanceof NdArray || isNumbers(value)) return true;
  return Array.isArray(value) && value.length > 24;
}

export function shapeOf(value: Value): string {
  if (value instanceof NdArray) return value.shape.join(' × ');
  const rows = value as ArrayLike<unknown>;
  const inner = rows[0];
  return Array.isArray(inner) ? `${rows.length} × ${inner.length}` : `${rows.length}`;
}

// ---- What a schema asks for ----

export type Kind = 'choice' | 'flag' | 'object' | 'map' | 'list' | 'vector' | 'text';

function alternatives(schema: Schema): Schema[] {
  return schema.anyOf ?? schema.oneOf ?? [];
}

/** The schema under a description of its own. */
export function bare(schema: Schema): Schema {
  return schema.allOf?.length === 1 ? { ...schema.allOf[0], ...schema } : schema;
}

const rules: [Kind, (schema: Schema) => boolean][] = [
  ['choice', ({ enum: names }) => names !== undefined],
  ['flag', ({ type }) => type === 'boolean'],
  ['object', ({ properties }) => properties !== undefined],
  ['map', ({ additionalProperties }) => typeof additionalProperties === 'object'],
  ['list', ({ type, items }) => type === 'array' && bare(items ?? {}).properties !== undefined],
  ['vector', (schema) => alternatives(schema).some(({ items }) => items?.anyOf?.some(({ type }) => type === 'string'))],
];

export function kindOf(schema: Schema): Kind {
  return rules.find(([, fits]) => fits(schema))?.[0] ?? 'text';
}

/** The inputs of a process as the properties of one object. */
export function schemaOf({ inputs }: ProcessDescription): Schema {
  const parts = Object.entries(inputs);
  return {
    type: 'object',
    properties: Object.fromEntries(parts.map(([name, { schema, description }]) => [name, { ...schema, description: schema.description ?? description }])),
    required: parts.filter(([, { minOccurs }]) => minOccurs === 1).map(([name]) => name),
  };
}

/** A first value for a member that is added. */
export function fresh(schema: Schema): Value {
  const kind = kindOf(schema);
  if (schema.default !== undefined) return schema.default;
  if (kind === 'choice') return schema.enum![0];
  if (kind === 'vector') return [0, 0];
  if (kind === 'list') return [fresh(bare(schema.items!))];
  if (kind === 'map') return {};
  if (kind === 'flag') return false;
  if (kind === 'object') {
    const required = schema.required ?? [];
    return Object.fromEntries(required.map((name) => [name, fresh(bare(schema.properties![name]!))]));
  }
  return schema.type === 'number' || schema.type === 'integer' ? (schema.minimum ?? 0) : '';
}

// ---- Errors ----

export interface FieldError {
  pointer: string;
  detail: string;
}

export function errorsUnder(errors: readonly FieldError[], pointer: string): FieldError[] {
  return errors.filter((error) => error.pointer === pointer || error.pointer.startsWith(`${pointer}/`));
}

/** Errors of an object that none of its shown members will show. */
export function ownErrors(errors: readonly FieldError[], pointer: string, shown: readonly string[]): FieldError[] {
  const members = shown.map((name) => child(pointer, name));
  return errorsUnder(errors, pointer).filter((error) =>
    !members.some((member) => error.pointer === member || error.pointer.startsWith(`${member}/`)));
}

export function fieldId(pointer: string): string {
  return `field:${pointer}`;
}

/** Moves the focus to the field of a pointer, or to the nearest one around it. */
export function focusField(pointer: string): void {
  for (let at = pointer; at; at = at.slice(0, at.lastIndexOf('/'))) {
    const field = document.getElementById(fieldId(at));
    if (!field) continue;
    field.scrollIntoView({ block: 'center' });
    field.focus();
    return;
  }
}
