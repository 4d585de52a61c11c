/** The cloud of a problem: a lattice, points of a file dropped here, or data kept at the daemon. */

import { NdArray, type Schema } from 'scatterd';
import { useState } from 'preact/hooks';
import { client } from '../lib/daemon';
import { readCloud, readJson } from '../lib/cloudfile';
import { count } from '../lib/text';
import { Group, Members, type FieldProps } from './Field';
import { child, fresh, shapeOf, type Value } from './value';

type Cloud = Record<string, Value>;

const keepAbove = 50_000; // numbers; larger clouds go to the daemon once and are referred to

function variants(schema: Schema): { lattice: Schema | undefined; points: Schema | undefined } {
  const having = (name: string): Schema | undefined => schema.oneOf?.find(({ properties }) => properties?.[name]);
  return { lattice: having('lattice')?.properties?.lattice, points: having('points') };
}

export function CloudField(props: FieldProps) {
  const { schema, pointer, value, errors, onChange } = props;
  const cloud = (value ?? {}) as Cloud;
  const { lattice } = variants(schema);
  const kind = 'lattice' in cloud ? 'lattice' : 'points';
  const choose = (next: string): void => {
    if (next !== kind) onChange(next === 'lattice' ? { lattice: fresh(latticeStart(lattice!)) } : { points: [] });
  };
  return (
    <Group {...props} shown={['lattice', 'points', 'groups', 'normals', 'spacing']} tools={
      <div class="segments" role="radiogroup" aria-label="Kind of cloud">
        {['lattice', 'points'].map((name) => (
          <button key={name} type="button" role="radio" aria-checked={kind === name} onClick={() => choose(name)}>
            {name === 'lattice' ? 'Lattice' : 'Own points'}
          </button>
        ))}
      </div>
    }>
      {kind === 'lattice' && lattice
        ? <Members name="lattice" schema={lattice} pointer={child(pointer, 'lattice')} value={cloud.lattice} errors={errors}
            onChange={(next) => onChange({ lattice: next })} />
        : <Points {...props} cloud={cloud} />}
    </Group>
  );
}

function latticeStart(schema: Schema): Schema {
  return { ...schema, default: { lower: [0, 0], upper: [1, 1], cells: [40, 40], jitter: 0.2, seed: 1 } };
}

/** Where files are dropped and JSON is pasted; what is there already is said in a line. */
function Points({ cloud, errors, pointer, onChange }: FieldProps & { cloud: Cloud }) {
  const [trouble, setTrouble] = useState('');
  const [over, setOver] = useState(false);
  const [pasting, setPasting] = useState(false);
  const wrong = errors.filter((error) => error.pointer.startsWith(pointer));

  const take = async (read: () => Promise<Cloud> | Cloud): Promise<void> => {
    try {
      const found = await read();
      onChange(await kept(found));
      setTrouble('');
      setPasting(false);
    } catch (error) {
      setTrouble((error as Error).message);
    }
  };
  const files = (list: FileList | null | undefined): void => {
    const file = list?.[0];
    if (file) void take(() => readCloud(file));
  };
  return (
    <>
      <div class={`drop${over ? ' over' : ''}`}
        onDragOver={(event) => { event.preventDefault(); setOver(true); }} onDragLeave={() => setOver(false)}
        onDrop={(event) => { event.preventDefault(); setOver(false); files(event.dataTransfer?.files); }}>
        <p>{summary(cloud) || 'Drop a file of points here: CSV (x, y, group), .npy or JSON.'}</p>
        <label class="button">
          Choose a file
          <input type="file" class="unseen" accept=".csv,.txt,.npy,.json" onChange={(event) => files(event.currentTarget.files)} />
        </label>
        <button type="button" class="quiet" onClick={() => setPasting(!pasting)} aria-expanded={pasting}>Paste JSON</button>
      </div>
      {pasting && (
        <textarea class="code" rows={5} aria-label="Points as JSON" placeholder='[[0, 0], [1, 0], ...] or {"points": [...], "groups": {...}}'
          onChange={(event) => void take(() => readJson(event.currentTarget.value))} />
      )}
      {trouble && <p class="errors" role="alert">This cannot be used: {trouble}.</p>}
      {wrong.length > 0 && <ul class="errors">{wrong.map(({ pointer: at, detail }) => <li key={at}>{at.slice(pointer.length + 1)}: {detail}</li>)}</ul>}
    </>
  );
}

/** Large clouds are sent to the daemon once; one that cannot keep data gets them with each request. */
async function kept(cloud: Cloud): Promise<Cloud> {
  const points = cloud.points as NdArray;
  if (points.data.length < keepAbove) return cloud;
  try {
    const { href } = await client.upload(cloud);
    return { href };
  } catch {
    return cloud;
  }
}

function summary(cloud: Cloud): string {
  if (typeof cloud.href === 'string') return `Kept at the daemon: ${cloud.href}`;
  const points = cloud.points as ArrayLike<unknown> | undefined;
  if (!points || points.length === 0) return '';
  const groups = Object.entries((cloud.groups ?? {}) as Record<string, ArrayLike<number>>);
  const named = groups.map(([name, group]) => `${name} (${count(group.length)})`);
  return `${shapeOf(points)} coordinates${named.length ? `; groups ${named.join(', ')}` : '; no groups'}`;
}
