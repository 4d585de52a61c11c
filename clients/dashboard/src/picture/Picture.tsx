/** The canvas of a scene with what one needs to read it: colour bar, values under the pointer. */

import { useEffect, useRef, useState } from 'preact/hooks';
import { table } from '../lib/colour';
import type { Look } from '../lib/look';
import { rangeOf, type Field, type Scene } from '../lib/scene';
import { number, some } from '../lib/text';
import type { Camera } from './camera';
import { ColourBar } from './ColourBar';
import type { Cut } from './overlay';
import { PictureView, type Probe, type Tool } from './view';

interface Props {
  scene: Scene;
  field: Field;
  values: Float64Array | undefined;
  range: [number, number];
  map: string;
  look: Look;
  tool: Tool;
  onCut: (cut: Cut) => void;
  onView: (view: PictureView) => void;
  onRange: (range: [number, number] | undefined) => void;
  /** Told when the view has come to rest. */
  onCamera: (camera: Camera | undefined) => void;
}

export function Picture({ scene, field, values, range, map, look, tool, onCut, onView, onRange, onCamera }: Props) {
  const host = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const overlay = useRef<HTMLCanvasElement>(null);
  const view = useRef<PictureView>();
  const latest = useRef({ onCut, onCamera });
  latest.current = { onCut, onCamera };
  const [probe, setProbe] = useState<Probe>();
  const [trouble, setTrouble] = useState('');

  useEffect(() => {
    try {
      view.current = new PictureView(host.current!, canvas.current!, overlay.current!, {
        probe: setProbe, camera: (camera) => latest.current.onCamera(camera), cut: (cut) => latest.current.onCut(cut),
      });
    } catch (error) {
      setTrouble((error as Error).message);
      return undefined;
    }
    const redraw = (): void => view.current?.redraw();
    addEventListener('themechange', redraw);
    return () => {
      removeEventListener('themechange', redraw);
      view.current?.dispose();
    };
  }, []);

  useEffect(() => {
    const { current } = view;
    if (!current) return;
    current.setScene(scene, look.camera);
    onView(current);
  }, [scene]);
  useEffect(() => view.current?.setColours(table(map), range), [map, range[0], range[1], scene]);
  useEffect(() => {
    if (values && values.length === scene.count) view.current?.setValues(values);
  }, [values, scene]);
  useEffect(() => view.current?.setShape(look.cells, look.size), [look.cells, look.size, scene]);
  useEffect(() => view.current?.setOpening(look.opened), [look.opened, scene]);
  useEffect(() => view.current?.setCut(look.cut), [look.cut, scene]);
  useEffect(() => {
    if (view.current) view.current.tool = tool;
  }, [tool]);
  useVectors(view.current, scene, look.arrows, 'setArrows');
  useVectors(view.current, scene, look.motion, 'setMotion');

  if (trouble) return <p class="empty" role="alert">{trouble}</p>;
  const [least, greatest] = values ? rangeOf(values) : [0, 0];
  const about = `${field.label} on ${some(scene.count, 'point')}, from ${number(least)} to ${number(greatest)}. ` +
    'Arrow keys move the picture, plus and minus zoom, 0 fits it, Shift with arrows reads off values.';
  return (
    <div class="picture">
      <div class={`canvas tool-${tool}`} ref={host}>
        <canvas ref={canvas} aria-hidden="true" />
        <canvas ref={overlay} class="hands" tabIndex={0} role="img" aria-label={about} />
        <output class="probe" aria-live="polite">
          {probe && values && <><b>{number(values[probe.point]!)}</b> at ({probe.place.map(number).join(', ')}) · point {probe.point}</>}
        </output>
      </div>
      <ColourBar map={map} range={range} label={field.label} onRange={onRange} />
    </div>
  );
}

/** Gives the view a vector field once its values are there. */
function useVectors(view: PictureView | undefined, scene: Scene, id: string, setter: 'setArrows' | 'setMotion'): void {
  useEffect(() => {
    const found = scene.dim === 2 ? scene.vectors.find((vector) => vector.id === id) : undefined;
    let current = true;
    if (!found) view?.[setter](undefined);
    else found.values().then((values) => current && view?.[setter](values), () => view?.[setter](undefined));
    return () => {
      current = false;
    };
  }, [view, scene, id]);
}
