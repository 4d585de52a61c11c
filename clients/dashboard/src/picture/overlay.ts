/** What is drawn over the points, on a canvas of two dimensions: axes, arrows, the cut, the place
 *  that is read off. */

import { scaleLinear } from 'd3-scale';
import { number } from '../lib/text';
import type { Scene } from '../lib/scene';
import type { PointGrid } from '../lib/grid';
import { project, unproject, type Camera, type Size } from './camera';

export interface Cut {
  from: [number, number];
  to: [number, number];
}

export interface Ink {
  text: string;
  faint: string;
  strong: string;
  paper: string;
}

type Context = CanvasRenderingContext2D;

/** Colours of the page, which differ in the dark. */
export function inkOf(element: Element): Ink {
  const style = getComputedStyle(element);
  const get = (name: string): string => style.getPropertyValue(name).trim();
  return { text: get('--ink-soft'), faint: get('--line'), strong: get('--ink'), paper: get('--panel') };
}

export function drawAxes(context: Context, camera: Camera, size: Size, ink: Ink): void {
  const [left, bottom] = unproject(camera, size, 0, size.height);
  const [right, top] = unproject(camera, size, size.width, 0);
  context.font = '11px system-ui, sans-serif';
  context.fillStyle = ink.text;
  context.strokeStyle = ink.text;
  context.lineWidth = 1;
  context.textBaseline = 'alphabetic';
  const column = scaleLinear([left, right], [0, size.width]);
  context.textAlign = 'center';
  for (const value of column.ticks(Math.max(2, size.width / 110))) {
    const x = Math.round(column(value)) + 0.5;
    if (x < 30 || x > size.width - 12) continue;
    mark(context, x, size.height, x, size.height - 5);
    halo(context, number(value), x, size.height - 9, ink);
  }
  const row = scaleLinear([bottom, top], [size.height, 0]);
  context.textAlign = 'left';
  context.textBaseline = 'middle';
  for (const value of row.ticks(Math.max(2, size.height / 80))) {
    const y = Math.round(row(value)) + 0.5;
    if (y < 10 || y > size.height - 24) continue;
    mark(context, 0, y, 5, y);
    halo(context, number(value), 9, y, ink);
  }
}

function mark(context: Context, x0: number, y0: number, x1: number, y1: number): void {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

/** Text that can be read on any colour. */
function halo(context: Context, text: string, x: number, y: number, ink: Ink): void {
  context.lineJoin = 'round';
  context.lineWidth = 3;
  context.strokeStyle = ink.paper;
  context.strokeText(text, x, y);
  context.lineWidth = 1;
  context.strokeStyle = ink.text;
  context.fillText(text, x, y);
}

/** The box of a cloud in space; beside its outermost edges the names of the axes, and how far they go. */
export function drawBox(context: Context, camera: Camera, size: Size, scene: Scene, ink: Ink): void {
  const corner = (bits: number): [number, number] =>
    project(camera, size, [0, 1, 2].map((k) => (bits >> k & 1 ? scene.upper : scene.lower)[k]!) as [number, number, number]);
  context.strokeStyle = ink.text;
  context.globalAlpha = 0.6;
  for (let bits = 0; bits < 8; bits++) {
    for (let k = 0; k < 3; k++) if (!(bits >> k & 1)) mark(context, ...corner(bits), ...corner(bits | 1 << k));
  }
  context.globalAlpha = 1;
  context.font = '12px system-ui, sans-serif';
  context.textAlign = 'center';
  context.fillStyle = ink.text;
  context.textBaseline = 'middle';
  const between = (a: number, b: number): [number, number] => [0, 1].map((k) => (corner(a)[k]! + corner(b)[k]!) / 2) as [number, number];
  const centre = between(0, 7);
  for (let k = 0; k < 3; k++) {
    const middles = [0, 1, 2, 3, 4, 5, 6, 7].filter((bits) => !(bits >> k & 1)).map((bits) => between(bits, bits | 1 << k));
    const distance = ([x, y]: [number, number]): number => Math.hypot(x - centre[0], y - centre[1]);
    const [x, y] = middles.reduce((far, middle) => (distance(middle) > distance(far) + 1 ? middle : far));
    const out = 34 / Math.max(1, distance([x, y]));
    halo(context, `${'xyz'[k]} ${number(scene.lower[k]!)} … ${number(scene.upper[k]!)}`, x + out * (x - centre[0]), y + out * (y - centre[1]), ink);
  }
}

export interface Arrows {
  /** Vectors [n][2] and the length of the longest. */
  vectors: Float64Array;
  strongest: number;
  /** How far from a point there may be an arrow (length). */
  reach: number;
}

/** Arrows of a vector field at the nodes of a square net, as long as the field is strong. */
export function drawArrows(
  context: Context, camera: Camera, size: Size, scene: Scene, grid: PointGrid, { vectors, strongest, reach }: Arrows, ink: Ink,
): void {
  const step = 34;
  context.lineCap = 'round';
  for (const [width, colour] of [[3.5, ink.paper], [1.4, ink.strong]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    for (let y = step / 2; y < size.height; y += step) {
      for (let x = step / 2; x < size.width; x += step) {
        const [u, v] = unproject(camera, size, x, y);
        const inside = [u, v].every((place, k) => place >= scene.lower[k]! && place <= scene.upper[k]!);
        const p = inside ? grid.nearest(u, v, reach) : -1;
        if (p >= 0) arrow(context, x, y, vectors[2 * p]!, vectors[2 * p + 1]!, (0.9 * step) / strongest);
      }
    }
    context.stroke();
  }
  context.lineWidth = 1;
}

function arrow(context: Context, x: number, y: number, u: number, v: number, scale: number): void {
  const length = Math.hypot(u, v) * scale;
  if (!(length > 1.5)) return;
  const angle = Math.atan2(-v, u);
  const [dx, dy] = [Math.cos(angle) * length / 2, Math.sin(angle) * length / 2];
  const head = Math.min(5, length / 2);
  context.moveTo(x - dx, y - dy);
  context.lineTo(x + dx, y + dy);
  for (const side of [-0.5, 0.5]) {
    context.moveTo(x + dx, y + dy);
    context.lineTo(x + dx - head * Math.cos(angle + side), y + dy - head * Math.sin(angle + side));
  }
}

export function drawCut(context: Context, camera: Camera, size: Size, { from, to }: Cut, ink: Ink): void {
  const [a, b] = [project(camera, size, [...from, 0]), project(camera, size, [...to, 0])];
  for (const [width, colour] of [[4, ink.paper], [1.5, ink.strong]] as const) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    mark(context, ...a, ...b);
  }
  [a, b].forEach(([x, y], k) => {
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.fillStyle = k ? ink.strong : ink.paper;
    context.fill();
    context.stroke();
  });
  context.lineWidth = 1;
}

export function drawProbe(context: Context, [x, y]: [number, number], ink: Ink): void {
  for (const [width, colour] of [[4, ink.paper], [1.6, ink.strong]] as const) {
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.beginPath();
    context.arc(x, y, 6, 0, 2 * Math.PI);
    context.stroke();
  }
  context.lineWidth = 1;
}
