/** The result as files, made from what is on the screen. */

import { useState } from 'preact/hooks';
import { asCsv, asDocument, asVtp, columnsOf, save } from '../lib/export';
import type { Field, Result, Scene } from '../lib/scene';
import { number } from '../lib/text';
import { paintMap } from '../picture/ColourBar';
import type { PictureView } from '../picture/view';

interface Props {
  result: Result;
  name: string;
  scene?: Scene;
  step?: number;
  field?: Field;
  view?: PictureView | undefined;
  map?: string;
  range?: [number, number];
}

export function Downloads({ result, name, scene, step = 0, field, view, map = 'viridis', range = [0, 1] }: Props) {
  const [trouble, setTrouble] = useState('');
  const guarded = (act: () => Promise<void> | void) => async (): Promise<void> => {
    try {
      setTrouble('');
      await act();
    } catch (error) {
      setTrouble((error as Error).message);
    }
  };
  const table = (write: typeof asCsv, type: string) => guarded(async () => {
    const own = ['solution', 'error', 'value', 'laplacian', 'velocity_x', 'velocity_y', 'velocity_z'];
    save(`${name}.${type}`, write(scene!, await columnsOf(scene!, step, [...own, field!.id])));
  });
  return (
    <div class="downloads">
      <span class="hint">Download as</span>
      <button type="button" onClick={guarded(() => save(`${name}.json`, asDocument(result, 'json')))}>JSON</button>
      <button type="button" onClick={guarded(() => save(`${name}.cbor`, asDocument(result, 'cbor')))}>CBOR</button>
      {scene && field && <button type="button" onClick={table(asCsv, 'csv')}>CSV</button>}
      {scene && field && <button type="button" onClick={table(asVtp, 'vtp')}>VTP for ParaView</button>}
      {view && field && (
        <button type="button" onClick={guarded(async () => save(`${name}.png`, await png(view, field.label, map, range)))}>PNG</button>
      )}
      {trouble && <p class="errors" role="alert">{trouble}</p>}
    </div>
  );
}

/** The picture with its colour bar below. */
function png(view: PictureView, label: string, map: string, range: [number, number]): Promise<Blob> {
  const style = getComputedStyle(document.documentElement);
  const [paper, ink] = ['--panel', '--ink'].map((name) => style.getPropertyValue(name).trim());
  const picture = view.snapshot(paper!);
  const unit = picture.width / 900;
  const whole = document.createElement('canvas');
  whole.width = picture.width;
  whole.height = picture.height + Math.round(64 * unit);
  const context = whole.getContext('2d')!;
  context.fillStyle = paper!;
  context.fillRect(0, 0, whole.width, whole.height);
  context.drawImage(picture, 0, 0);
  const strip = document.createElement('canvas');
  paintMap(strip, map);
  const [left, top, width] = [0.2 * whole.width, picture.height + 12 * unit, 0.6 * whole.width];
  context.drawImage(strip, left, top, width, 14 * unit);
  context.fillStyle = ink!;
  context.font = `${13 * unit}px system-ui, sans-serif`;
  context.textAlign = 'center';
  [range[0], range[1]].forEach((value, k) => context.fillText(number(value), left + k * width, top + 32 * unit));
  context.fillText(label, left + width / 2, top + 32 * unit);
  return new Promise((resolve, reject) => {
    whole.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the browser made no picture'))), 'image/png');
  });
}
