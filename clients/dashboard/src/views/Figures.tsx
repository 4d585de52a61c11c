/** The numbers of a result that are not fields, as short tables. */

import { flat, type Result } from '../lib/scene';
import { plainName } from '../form/Field';
import { bytes, number, seconds } from '../lib/text';

const tables = ['norms', 'vortex', 'diagnostics', 'summary', 'report'];

function isFlat(value: unknown): boolean {
  return typeof value !== 'object' || ArrayBuffer.isView(value) || Array.isArray(value);
}

/** Members with their names joined: spacing, min. */
function rows(value: object, before = ''): [string, unknown][] {
  return Object.entries(value).flatMap(([name, item]): [string, unknown][] => {
    const whole = before ? `${before}, ${name.replaceAll('_', ' ')}` : plainName(name);
    return isFlat(item) || item === null ? [[whole, item]] : rows(item as object, whole);
  });
}

function show(name: string, value: unknown): string {
  if (typeof value === 'number') {
    if (/bytes$/i.test(name)) return bytes(value);
    if (/^Seconds/.test(name)) return seconds(value);
    return number(value);
  }
  if (typeof value === 'object' && value !== null) {
    const list = Array.from(flat(value));
    return list.length > 6 ? `${list.length} numbers` : list.map(number).join(', ') || 'none';
  }
  return String(value);
}

export function Figures({ result }: { result: Result }) {
  const loose = Object.entries(result).filter(([, value]) => ['number', 'string'].includes(typeof value));
  return (
    <div class="figures">
      {loose.length > 0 && <Table name="result" value={Object.fromEntries(loose)} />}
      {tables.filter((name) => result[name]).map((name) => <Table key={name} name={name} value={result[name] as object} />)}
    </div>
  );
}

function Table({ name, value }: { name: string; value: object }) {
  return (
    <table>
      <caption>{plainName(name)}</caption>
      <tbody>
        {rows(value).map(([label, item]) => <tr key={label}><th scope="row">{label}</th><td>{show(label, item)}</td></tr>)}
      </tbody>
    </table>
  );
}
