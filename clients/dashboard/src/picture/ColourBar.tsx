/** What the colours mean; the ends can be typed. */

import { useEffect, useRef, useState } from 'preact/hooks';
import { table } from '../lib/colour';
import { number } from '../lib/text';

interface Props {
  map: string;
  range: [number, number];
  label: string;
  onRange: (range: [number, number] | undefined) => void;
}

/** Paints a map into a canvas of one row. */
export function paintMap(canvas: HTMLCanvasElement, map: string): void {
  canvas.width = 256;
  canvas.height = 1;
  const pixels = new ImageData(new Uint8ClampedArray(table(map)), 256, 1);
  canvas.getContext('2d')!.putImageData(pixels, 0, 0);
}

export function ColourBar({ map, range, label, onRange }: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => paintMap(canvas.current!, map), [map]);
  const [least, greatest] = range;
  const set = (end: 0 | 1, value: number | undefined): void => {
    if (value === undefined || !Number.isFinite(value)) onRange(undefined);
    else onRange(end ? [least, value] : [value, greatest]);
  };
  return (
    <div class="colour-bar">
      <End name={`Least ${label}`} value={least} onChange={(value) => set(0, value)} />
      <div class="colour-strip">
        <canvas ref={canvas} aria-hidden="true" />
        <div class="colour-ticks" aria-hidden="true">
          {[0.25, 0.5, 0.75].map((part) => <span key={part}>{number(between(range, part))}</span>)}
        </div>
      </div>
      <End name={`Greatest ${label}`} value={greatest} onChange={(value) => set(1, value)} />
    </div>
  );
}

/** A value between the ends; what is nothing but rounding is 0. */
function between([least, greatest]: [number, number], part: number): number {
  const value = least + part * (greatest - least);
  return Math.abs(value) < 1e-3 * (greatest - least) ? 0 : value;
}

/** One end of the range; emptied, it goes back to that of the values. */
function End({ name, value, onChange }: { name: string; value: number; onChange: (value: number | undefined) => void }) {
  const [text, setText] = useState('');
  useEffect(() => setText(number(value)), [value]);
  const read = (): void => onChange(text.trim() ? Number(text.replace('−', '-').replace('e−', 'e-')) : undefined);
  return (
    <input class="code range-end" aria-label={name} title="Empty: the range of the values" value={text}
      onInput={(event) => setText(event.currentTarget.value)} onChange={read} />
  );
}
