/** Curves in a frame, as SVG: sizes follow the page, colours follow its theme, and a reader that
 *  sees nothing gets the numbers as a table. */

import { scaleLinear, scaleLog } from 'd3-scale';
import { useId, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { number } from '../lib/text';

export interface Curve {
  label: string;
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  marks?: boolean;
  dashed?: boolean;
}

export interface Axis {
  label: string;
  log?: boolean;
}

interface Props {
  title: string;
  curves: Curve[];
  x: Axis;
  y: Axis;
  /** Triangles that show slopes of a plot whose axes are both logarithmic. */
  slopes?: number[];
  height?: number;
}

const [narrowest, widest] = [280, 720];
const room = { left: 62, right: 14, top: 12, bottom: 40 };

type Scale = ((value: number) => number) & { ticks: (count?: number) => number[] };

function scaleOf({ log }: Axis, values: number[], range: [number, number]): Scale {
  const good = values.filter((value) => Number.isFinite(value) && (!log || value > 0));
  let [least, greatest] = [Math.min(...good), Math.max(...good)];
  if (good.length === 0) [least, greatest] = [log ? 0.1 : 0, 1];
  if (log) return scaleLog([least / 1.3, greatest * 1.3], range) as unknown as Scale;
  const pad = (greatest - least || Math.abs(greatest) || 1) * 0.04;
  return scaleLinear([least - pad, greatest + pad], range) as unknown as Scale;
}

/** Ticks of a logarithmic axis: powers of ten, and if these are few, twice and five times them. */
function ticksOf(scale: Scale, { log }: Axis, wanted: number): number[] {
  const all = scale.ticks(wanted);
  if (!log) return all;
  const leading = (value: number): number => Math.round(value / 10 ** Math.floor(Math.log10(value) + 1e-9));
  const choices = [[1], [1, 2, 5]].map((digits) => all.filter((value) => digits.includes(leading(value))));
  return choices.find((ticks) => ticks.length >= 2) ?? all;
}

/** The room there is on the page: letters keep their size, whatever it is. */
function useWidth(figure: { readonly current: HTMLElement | null }): number {
  const [width, setWidth] = useState(560);
  useLayoutEffect(() => {
    const measure = (): void => {
      const there = figure.current!.clientWidth;
      if (there > 0) setWidth(Math.min(widest, Math.max(narrowest, there)));
    };
    measure();
    const observer = new ResizeObserver(measure);
    observer.observe(figure.current!);
    return () => observer.disconnect();
  }, []);
  return width;
}

export function LinePlot({ title, curves, x, y, slopes = [], height = 260 }: Props) {
  const id = useId();
  const figure = useRef<HTMLElement>(null);
  const width = useWidth(figure);
  const [near, setNear] = useState<{ curve: number; k: number }>();
  const gather = (axis: 'x' | 'y'): number[] => curves.flatMap((curve) => Array.from(curve[axis]));
  const sx = scaleOf(x, gather('x'), [room.left, width - room.right]);
  const sy = scaleOf(y, gather('y'), [height - room.bottom, room.top]);
  const good = (c: Curve, k: number): boolean => Number.isFinite(sx(c.x[k]!)) && Number.isFinite(sy(c.y[k]!));

  const follow = (event: MouseEvent): void => {
    const box = (event.currentTarget as SVGElement).getBoundingClientRect();
    const [px, py] = [((event.clientX - box.left) * width) / box.width, ((event.clientY - box.top) * height) / box.height];
    let best = 900;
    let found: typeof near;
    curves.forEach((c, curve) => {
      for (let k = 0; k < c.x.length; k++) {
        const distance = good(c, k) ? (sx(c.x[k]!) - px) ** 2 + (sy(c.y[k]!) - py) ** 2 : Infinity;
        if (distance < best) [best, found] = [distance, { curve, k }];
      }
    });
    setNear(found);
  };
  const pick = near && curves[near.curve];

  return (
    <figure class="plot" ref={figure}>
      <svg viewBox={`0 0 ${width} ${height}`} role="img" aria-labelledby={id} onMouseMove={follow} onMouseLeave={() => setNear(undefined)}>
        <title id={id}>{title}</title>
        <g class="plot-grid">
          {ticksOf(sx, x, width / 90).map((value) => (
            <g key={value}>
              <line x1={sx(value)} x2={sx(value)} y1={room.top} y2={height - room.bottom} />
              <text x={sx(value)} y={height - room.bottom + 15} text-anchor="middle">{number(value)}</text>
            </g>
          ))}
          {ticksOf(sy, y, height / 52).map((value) => (
            <g key={value}>
              <line x1={room.left} x2={width - room.right} y1={sy(value)} y2={sy(value)} />
              <text x={room.left - 6} y={sy(value) + 4} text-anchor="end">{number(value)}</text>
            </g>
          ))}
        </g>
        <text class="plot-axis" x={(room.left + width - room.right) / 2} y={height - 6} text-anchor="middle">{x.label}</text>
        <text class="plot-axis" transform={`translate(13 ${(room.top + height - room.bottom) / 2}) rotate(-90)`} text-anchor="middle">{y.label}</text>
        {slopes.map((slope) => <Slope key={slope} slope={slope} curves={curves} sx={sx} sy={sy} />)}
        {curves.map((c, k) => (
          <g key={c.label} class={`curve curve-${k % 6}`}>
            <path d={pathOf(c, sx, sy, good)} class={c.dashed ? 'dashed' : undefined} />
            {c.marks && Array.from(c.x, (value, p) => good(c, p) && <circle key={p} cx={sx(value)} cy={sy(c.y[p]!)} r="3.5" />)}
          </g>
        ))}
        {pick && near && (
          <g class="plot-pick">
            <circle cx={sx(pick.x[near.k]!)} cy={sy(pick.y[near.k]!)} r="5" />
            <text x={Math.min(width - 150, Math.max(room.left + 4, sx(pick.x[near.k]!) + 9))} y={Math.max(room.top + 12, sy(pick.y[near.k]!) - 9)}>
              {`${number(pick.x[near.k]!)}, ${number(pick.y[near.k]!)}`}
            </text>
          </g>
        )}
      </svg>
      {curves.length > 1 && (
        <figcaption class="legend">
          {curves.map((c, k) => <span key={c.label} class={`curve-${k % 6}`}><i aria-hidden="true" class={c.dashed ? 'dashed' : undefined} />{c.label}</span>)}
        </figcaption>
      )}
      <Numbers title={title} curves={curves} x={x} y={y} />
    </figure>
  );
}

function pathOf(c: Curve, sx: Scale, sy: Scale, good: (c: Curve, k: number) => boolean): string {
  let path = '';
  let pen = 'M';
  for (let k = 0; k < c.x.length; k++) {
    if (!good(c, k)) {
      pen = 'M';
      continue;
    }
    path += `${pen}${sx(c.x[k]!).toFixed(1)} ${sy(c.y[k]!).toFixed(1)}`;
    pen = 'L';
  }
  return path;
}

/** A triangle of this slope below the last curve's end. */
function Slope({ slope, curves, sx, sy }: { slope: number; curves: Curve[]; sx: Scale; sy: Scale }) {
  const first = curves[0];
  if (!first || first.x.length < 2) return null;
  const xs = Array.from(first.x).sort((a, b) => a - b);
  const [x0, x1] = [xs[0]!, Math.sqrt(xs[0]! * xs[xs.length - 1]!)];
  const base = Math.min(...Array.from(first.y).filter((value) => value > 0));
  const y1 = base * (x1 / x0) ** slope;
  if (![x0, x1, base, y1].every((value) => value > 0 && Number.isFinite(value))) return null;
  return (
    <g class="plot-slope">
      <path d={`M${sx(x0)} ${sy(base)}L${sx(x1)} ${sy(base)}L${sx(x1)} ${sy(y1)}Z`} />
      <text x={sx(x1) + 5} y={(sy(base) + sy(y1)) / 2 + 4}>{number(slope)}</text>
    </g>
  );
}

function Numbers({ title, curves, x, y }: Pick<Props, 'title' | 'curves' | 'x' | 'y'>) {
  const total = curves.reduce((sum, c) => sum + c.x.length, 0);
  if (total > 120) return null;
  return (
    <table class="unseen">
      <caption>{title}</caption>
      <thead><tr><th scope="col">Curve</th><th scope="col">{x.label}</th><th scope="col">{y.label}</th></tr></thead>
      <tbody>
        {curves.flatMap((c) => Array.from(c.x, (value, k) => (
          <tr key={`${c.label} ${k}`}><td>{c.label}</td><td>{number(value)}</td><td>{number(c.y[k]!)}</td></tr>
        )))}
      </tbody>
    </table>
  );
}
