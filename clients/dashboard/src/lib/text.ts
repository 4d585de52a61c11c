/** Numbers for people. */

const minus = (text: string): string => text.replaceAll('-', '−');

function grouped(value: number): string {
  return minus(String(value)).replace(/\B(?=(\d{3})+$)/g, ' '); // a narrow space that does not break
}

/** Four digits, with a real minus: 0.01034, 1.2e−5; whole numbers whole. */
export function number(value: number): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? 'no number' : value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e7) return grouped(value);
  if (size >= 1e-3 && size < 1e5) return minus(String(Number(value.toPrecision(4))));
  return minus(value.toExponential(3).replace(/\.?0*e\+?/, 'e'));
}

export function count(value: number): string {
  return grouped(value);
}

export function seconds(value: number): string {
  if (value < 1) return `${Number((value * 1000).toPrecision(3))} ms`;
  if (value < 120) return `${Number(value.toPrecision(3))} s`;
  return `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}

export function bytes(value: number): string {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  const k = Math.min(4, Math.max(0, Math.floor(Math.log10(value || 1) / 3)));
  return `${Number((value / 1000 ** k).toPrecision(3))} ${units[k]}`;
}

export function when(time: string | undefined): string {
  if (!time) return '';
  const date = new Date(time);
  const today = new Date().toDateString() === date.toDateString();
  return today ? date.toLocaleTimeString() : date.toLocaleString();
}

/** "1 point", "2 points". */
export function some(value: number, one: string): string {
  return `${count(value)} ${one}${value === 1 ? '' : 's'}`;
}
