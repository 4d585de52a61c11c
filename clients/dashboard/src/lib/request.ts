/** A request as the page keeps it: the process and its inputs. Arrays that a person dropped in are
 *  NdArrays, all else is what JSON can say. */

import { encode, isNumbers, NdArray } from 'scatterd';

export interface Request {
  process: string;
  inputs: Record<string, unknown>;
}

/** How many numbers are in a value. */
export function sizeOf(value: unknown): number {
  if (value instanceof NdArray || ArrayBuffer.isView(value)) return (value as NdArray).length;
  if (Array.isArray(value)) return value.reduce((sum: number, item) => sum + sizeOf(item), 0);
  if (value && typeof value === 'object') return sizeOf(Object.values(value));
  return 1;
}

/** JSON with short arrays on one line, so that it reads like what one would write by hand. */
export function pretty(value: unknown, indent = ''): string {
  const flat = encode(value ?? null, 'json') as string;
  if (flat.length + indent.length <= 76) return spaced(flat);
  const plain = value instanceof NdArray ? value.toJSON() : isNumbers(value) ? Array.from(value) : value;
  const deeper = `${indent}  `;
  if (Array.isArray(plain)) {
    return `[\n${plain.map((item) => deeper + pretty(item, deeper)).join(',\n')}\n${indent}]`;
  }
  if (plain && typeof plain === 'object') {
    const rows = Object.entries(plain).map(([key, item]) => `${deeper}${JSON.stringify(key)}: ${pretty(item, deeper)}`);
    return `{\n${rows.join(',\n')}\n${indent}}`;
  }
  return flat;
}

/** A space after every comma and colon that is not in a string. */
function spaced(json: string): string {
  return json.replace(/"(?:[^"\\]|\\.)*"|[,:]/g, (part) => (part === ',' || part === ':' ? `${part} ` : part));
}

// ---- Packing into a link ----

/** Deflated and in base64url; undefined if there is more of it than a link can carry. */
export async function pack(request: Request, most = 6000): Promise<string | undefined> {
  if (sizeOf(request.inputs) > 20_000) return undefined;
  const stream = new Blob([encode(request, 'json') as string]).stream().pipeThrough(new CompressionStream('deflate-raw'));
  const packed = new Uint8Array(await new Response(stream).arrayBuffer());
  const text = btoa(String.fromCharCode(...packed)).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
  return text.length <= most ? text : undefined;
}

export async function unpack(text: string): Promise<Request> {
  const packed = Uint8Array.from(atob(text.replace(/-/g, '+').replace(/_/g, '/')), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return JSON.parse(await new Response(stream).text()) as Request;
}

// ---- For use elsewhere ----

export function asCurl({ process, inputs }: Request, base: string): string {
  const quoted = pretty({ inputs }).replaceAll("'", "'\\''");
  return `curl -H 'Content-Type: application/json' '${base}processes/${process}/execution' -d '${quoted}'`;
}

export function asPython({ process, inputs }: Request, base: string): string {
  const call = ['solve', 'apply', 'diagnose'].includes(process)
    ? `client.${process}(\n${named(inputs)})`
    : process === 'batch'
      ? `client.submit("batch", ${python(inputs, '    ')}).result()`
      : `client.execute("${process}", ${python(inputs, '    ')})`;
  return [
    'import scatterd',
    '',
    `client = scatterd.Client("${base.replace(/\/$/, '')}")`,
    `result = ${call}`,
    'print(result)',
  ].join('\n');
}

function named(inputs: Record<string, unknown>): string {
  return Object.entries(inputs).map(([name, value]) => `    ${name}=${python(value, '    ')},\n`).join('');
}

/** JSON is Python but for three words. */
function python(value: unknown, indent: string): string {
  const words: Record<string, string> = { true: 'True', false: 'False', null: 'None' };
  return pretty(value, indent).replace(/"(?:[^"\\]|\\.)*"|\b(?:true|false|null)\b/g, (part) => words[part] ?? part);
}
