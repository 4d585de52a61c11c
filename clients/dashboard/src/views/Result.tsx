/** What came out of a run: the picture, its controls, plots and numbers. */

import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { maps } from '../lib/colour';
import { firstLook, type Look } from '../lib/look';
import { rangeOf, sceneOf, type Field, type Result as Values, type Scene } from '../lib/scene';
import type { Request } from '../lib/request';
import { number, seconds as inSeconds, some } from '../lib/text';
import { Picture } from '../picture/Picture';
import type { PictureView, Tool } from '../picture/view';
import { LinePlot } from '../plots/LinePlot';
import { FlowPlots } from '../plots/FlowPlots';
import { HistoryPlot } from '../plots/HistoryPlot';
import { Tabs } from '../ui/Tabs';
import { Downloads } from './Downloads';
import { Figures } from './Figures';
import { StudyResult } from './StudyResult';

interface Props {
  request: Request;
  result: Values;
  seconds: number;
  look: Look;
  onLook: (look: Look) => void;
}

export function Result(props: Props) {
  const { request, result } = props;
  const scene = useMemo(() => sceneOf(request, result), [request, result]);
  if (result.table) return <StudyResult {...props} />;
  if (!scene) return <Plain {...props} />;
  return <SceneResult {...props} scene={scene} />;
}

function Plain({ request, result }: Props) {
  return (
    <section class="card plain">
      <Downloads result={result} name={request.process} />
      <Figures result={result} />
      <pre class="code tall-text" tabIndex={0}>{JSON.stringify(result, null, 2)?.slice(0, 20_000)}</pre>
    </section>
  );
}

/** Values of a field at a time, while they are being made the last ones. */
function useValues(field: Field, step: number): { values: Float64Array | undefined; trouble: string; busy: boolean } {
  const [state, setState] = useState<{ values?: Float64Array; field?: Field; trouble: string; busy: boolean }>({ trouble: '', busy: true });
  useEffect(() => {
    let current = true;
    setState((before) => ({ ...before, trouble: '', busy: true }));
    field.values(step).then(
      (values) => current && setState({ values, field, trouble: '', busy: false }),
      (error) => current && setState({ trouble: (error as Error).message, busy: false }),
    );
    return () => {
      current = false;
    };
  }, [field, step]);
  return { values: state.values, trouble: state.trouble, busy: state.busy };
}

/** Symmetric about zero where the sign matters. */
function rangeFor(field: Field, values: Float64Array | undefined): [number, number] {
  const [least, greatest] = values ? rangeOf(values) : [0, 1];
  if (!field.signed || least >= 0) return [least, greatest];
  const size = Math.max(-least, greatest) || 1;
  return [-size, size];
}

/** The range that holds both: it grows over the times that have been looked at, and stays. */
function joined([least, greatest]: [number, number], before: [number, number] | undefined): [number, number] {
  return before ? [Math.min(least, before[0]), Math.max(greatest, before[1])] : [least, greatest];
}

function SceneResult({ request, result, seconds, look, onLook, scene: whole }: Props & { scene: Scene }) {
  const [tool, setTool] = useState<Tool>('move');
  const view = useRef<PictureView>();
  const [, setReady] = useState(0);
  const steps = whole.times?.length ?? 0;
  const step = steps ? (look.step < 0 ? steps - 1 : Math.min(look.step, steps - 1)) : 0;
  const scene = whole.snapshots?.[step] ?? whole;
  const field = scene.fields.find(({ id }) => id === look.field) ?? scene.fields[0]!;
  const { values, trouble, busy } = useValues(field, step);
  const kept = useRef<{ id: string; range: [number, number] }>();
  if (values && !busy) {
    const before = kept.current?.id === field.id ? kept.current.range : undefined;
    kept.current = { id: field.id, range: joined(rangeFor(field, values), before) };
  }
  const range = look.range ?? kept.current?.range ?? [0, 1];
  const map = look.map || (field.signed && range[0] < 0 ? 'diverging' : 'viridis');
  const set = (part: Partial<Look>): void => onLook({ ...look, ...part });
  const cutCurve = values && look.cut && view.current && scene.dim === 2 ? view.current.along(look.cut, values) : undefined;
  const useCut = (next: Tool): void => {
    setTool(next);
    if (next === 'cut' && !look.cut && scene.dim === 2) set({ cut: middle(scene) });
  };

  return (
    <div class="result">
      <section class="card stage" aria-label="Picture">
        <div class="stage-bar">
          <label class="pick"><span>Colour</span>
            <select value={field.id} onChange={(event) => set({ field: event.currentTarget.value, range: undefined, map: '' })}>
              {scene.fields.map(({ id, label }) => <option key={id} value={id}>{label}</option>)}
            </select>
          </label>
          {scene.dim > 1 && <label class="pick"><span>Map</span>
            <select value={map} onChange={(event) => set({ map: event.currentTarget.value })}>
              {Object.entries(maps).map(([name, { label }]) => <option key={name} value={name}>{label}</option>)}
            </select>
          </label>}
          {scene.dim === 3 && (
            <label class="pick"><span>Open</span>
              <input type="range" min={0} max={1} step={0.02} value={look.opened} onInput={(event) => set({ opened: Number(event.currentTarget.value) })} />
            </label>
          )}
          {scene.dim === 2 && <VectorPick label="Arrows" value={look.arrows} scene={scene} onChange={(arrows) => set({ arrows })} />}
          {scene.dim === 2 && <VectorPick label="Motion" value={look.motion} scene={scene} onChange={(motion) => set({ motion })} />}
          {scene.dim > 1 && <ShapePick look={look} dim={scene.dim} set={set} />}
          <span class="spring" />
          {scene.dim === 2 && (
            <button type="button" class="quiet" aria-pressed={tool === 'cut'} onClick={() => useCut(tool === 'cut' ? 'move' : 'cut')}>Cut</button>
          )}
          {scene.dim > 1 && <button type="button" class="quiet" onClick={() => view.current?.fit()}>Fit</button>}
        </div>
        {scene.dim === 1
          ? values && <Line scene={scene} field={field} values={values} />
          : <Picture scene={scene} field={field} values={values} range={range} map={map} look={look} tool={tool}
              onCut={(cut) => set({ cut })} onView={(made) => { view.current = made; setReady((n) => n + 1); }} onRange={(next) => set({ range: next })} onCamera={(camera) => set({ camera })} />}
        {trouble && <p class="errors" role="alert">{field.label} cannot be shown: {trouble}</p>}
        {steps > 1 && whole.times && <TimeSlider times={whole.times} step={step} onStep={(next) => set({ step: next })} />}
        <p class="stage-foot">
          {busy ? 'Computing the values …' : `${some(scene.count, 'point')} · solved and received in ${inSeconds(seconds)}`}
        </p>
      </section>
      <section class="card lower">
        <Tabs label="More about the result" tabs={{
          Numbers: () => <Figures result={result} />,
          ...(scene.dim === 2 && { Cut: () => cutCurve
            ? <CutPlot field={field} look={look} curve={cutCurve} set={set} />
            : <p class="hint">Choose “Cut” above the picture and draw a line across it: the values along it appear here. <button type="button" class="link" onClick={() => useCut('cut')}>Cut through the middle</button></p> }),
          ...((result.history as Values | undefined)?.solution !== undefined && { History: () => <HistoryPlot history={result.history as Values} /> }),
          ...(request.process === 'flow' && { Flow: () => <FlowPlots result={result} /> }),
          Download: () => <Downloads result={result} name={request.process} scene={scene} step={step} field={field} view={view.current} map={map} range={range} />,
        }} />
      </section>
    </div>
  );
}

function middle({ lower, upper }: Scene): NonNullable<Look['cut']> {
  const y = (lower[1]! + upper[1]!) / 2;
  return { from: [lower[0]!, y], to: [upper[0]!, y] };
}

function VectorPick({ label, value, scene, onChange }: { label: string; value: string; scene: Scene; onChange: (id: string) => void }) {
  if (scene.vectors.length === 0) return null;
  return (
    <label class="pick"><span>{label}</span>
      <select value={value} onChange={(event) => onChange(event.currentTarget.value)}>
        <option value="">None</option>
        {scene.vectors.map(({ id, label: name }) => <option key={id} value={id}>{name}</option>)}
      </select>
    </label>
  );
}

function ShapePick({ look, dim, set }: { look: Look; dim: number; set: (part: Partial<Look>) => void }) {
  return (
    <label class="pick"><span>Points</span>
      <select value={look.cells && dim === 2 ? 'cells' : `${look.size}`}
        onChange={({ currentTarget: { value } }) => set(value === 'cells' ? { cells: true, size: 1 } : { cells: false, size: Number(value) })}>
        {dim === 2 && <option value="cells">Cells</option>}
        {[[0.4, 'Small dots'], [1, 'Dots'], [1.6, 'Large dots']].map(([size, label]) => <option key={label} value={`${size}`}>{label}</option>)}
      </select>
    </label>
  );
}

function Line({ scene, field, values }: { scene: Scene; field: Field; values: Float64Array }) {
  const order = Array.from({ length: scene.count }, (_, p) => p).sort((a, b) => scene.points[a]! - scene.points[b]!);
  const curve = { label: field.label, x: order.map((p) => scene.points[p]!), y: order.map((p) => values[p]!), marks: scene.count <= 80 };
  return <LinePlot title={field.label} curves={[curve]} x={{ label: 'x' }} y={{ label: field.label }} />;
}

function CutPlot({ field, look, curve, set }: { field: Field; look: Look; curve: { s: number[]; value: number[] }; set: (part: Partial<Look>) => void }) {
  const { from, to } = look.cut ?? { ...firstLook, from: [0, 0], to: [0, 0] };
  const ends = [...from, ...to];
  const move = (k: number, text: string): void => {
    const next = ends.map((value, p) => (p === k ? Number(text) : value));
    if (next.every(Number.isFinite)) set({ cut: { from: [next[0]!, next[1]!], to: [next[2]!, next[3]!] } });
  };
  return (
    <>
      <div class="cut-ends">
        {['from x', 'from y', 'to x', 'to y'].map((label, k) => (
          <label key={label}>{label}<input class="code" value={String(Number(ends[k]!.toPrecision(6)))} onChange={(event) => move(k, event.currentTarget.value)} /></label>
        ))}
        <button type="button" class="quiet" onClick={() => set({ cut: undefined })}>Remove</button>
      </div>
      <LinePlot title={`${field.label} along the cut`} curves={[{ label: field.label, x: curve.s, y: curve.value }]} x={{ label: 'distance along the cut' }} y={{ label: field.label }} />
    </>
  );
}

function TimeSlider({ times, step, onStep }: { times: Float64Array; step: number; onStep: (step: number) => void }) {
  const [playing, setPlaying] = useState(false);
  useEffect(() => {
    if (!playing) return undefined;
    const timer = setTimeout(() => onStep((step + 1) % times.length), 350);
    return () => clearTimeout(timer);
  }, [playing, step]);
  return (
    <div class="time">
      <button type="button" class="quiet" onClick={() => setPlaying(!playing)}>{playing ? 'Pause' : 'Play'}</button>
      <input type="range" min={0} max={times.length - 1} step={1} value={step} aria-label="Time" aria-valuetext={`t = ${number(times[step]!)}`}
        onInput={(event) => onStep(Number(event.currentTarget.value))} />
      <output>t = {number(times[step]!)}</output>
    </div>
  );
}

