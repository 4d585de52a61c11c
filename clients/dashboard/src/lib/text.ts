/** Numbers for people. */

import { format } from 'd3-format';

const short = format('.4~g');
const thousands = format(',');

/** Four digits, with a real minus: 0.01034, 1.2e-5. */
export function number(value: number): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? 'no number' : value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  const text = size < 1e-3 || size >= 1e6 ? value.toExponential(3).replace(/\.?0+e/, 'e').replace('e+', 'e') : short(value);
  return text.replace(/^[-−]/, '−').replace('e-', 'e−');
}

export function count(value: number): string {
  return thousands(value).replaceAll(',', ' ');
}

export function seconds(value: number): string {
  if (value < 1) return `${number(value * 1000)} ms`;
  if (value < 120) return `${short(value)} s`;
  return `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}

export function bytes(value: number): string {
  const unit = value < 1e3 ? 'B' : value < 1e6 ? 'kB' : value < 1e9 ? 'MB' : 'GB';
  const scale = { B: 1, kB: 1e3, MB: 1e6, GB: 1e9 }[unit];
  return `${format('.3~r')(value / scale)} ${unit}`;
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
