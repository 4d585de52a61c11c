/** A study: its table beside the paper's numbers, errors over mesh size, sections and histories. */

import { useState } from 'preact/hooks';
import { flat, type Result } from '../lib/scene';
import { pack, type Request } from '../lib/request';
import { goTo } from '../lib/route';
import { number, some } from '../lib/text';
import { LinePlot, type Curve } from '../plots/LinePlot';
import { Downloads } from './Downloads';

type Row = Record<string, unknown> & { cells: number; paper?: Record<string, number> };

interface Reference {
  title: string;
  equation: string;
  source: string;
  where: string;
  notes: string[];
}

const norms: [string, string][] = [['l2', 'root mean square'], ['linf', 'maximum'], ['l1', 'mean']];
const sections: [string, string][] = [['outlet', 'Along the outlet'], ['profile', 'Along the row of the profile']];

export function StudyResult({ result }: { result: Result }) {
  const table = result.table as Row[];
  const reference = result.reference as Reference | undefined;
  return (
    <div class="result">
      <section class="card study">
        {reference && (
          <header>
            <h2>{reference.title}</h2>
            <p class="code equation">{reference.equation}</p>
            <p class="hint">{reference.source}; {reference.where}.</p>
          </header>
        )}
        <StudyTable table={table} requests={result.requests as Request[] | undefined} />
        {reference && reference.notes.length > 0 && <ul class="notes">{reference.notes.map((note) => <li key={note}>{note}</li>)}</ul>}
        <Downloads result={result} name="study" />
      </section>
      <section class="card lower plots">
        <Convergence table={table} />
        {sections.map(([name, title]) => <Sections key={name} name={name} title={title} table={table} />)}
        <Histories table={table} />
      </section>
    </div>
  );
}

/** Columns that every reader wants, with what they are. */
const first = new Map([
  ['cells', 'cells along the unit of length'],
  ['points', 'points of the cloud'],
  ['l2', 'root mean square of the error on inner points'],
  ['rate_l2', 'order of l2 from the row before'],
  ['linf', 'greatest error on inner points'],
  ['rate_linf', 'order of linf from the row before'],
  ['linf_all', 'greatest error on all points'],
  ['seconds', 'time of one run (s)'],
]);
const furtherOf = 10; // with more columns than this, those that are not among the first are asked for

interface Column {
  name: string;
  paper: boolean;
}

/** Members that are plain numbers, the telling ones first; after each what the paper printed. */
function columnsOf(table: Row[]): Column[] {
  const own = new Set(table.flatMap((row) => Object.keys(row).filter((name) => typeof row[name] === 'number')));
  const printed = new Set(table.flatMap(({ paper }) => Object.keys(paper ?? {})));
  const names = [...[...first.keys()].filter((name) => own.has(name)), ...[...own].filter((name) => !first.has(name))];
  return names.flatMap((name) => [{ name, paper: false }, ...(printed.has(name) ? [{ name, paper: true }] : [])]);
}

function cell(row: Row, { name, paper }: Column): string {
  const value = paper ? row.paper?.[name] : row[name];
  return typeof value === 'number' ? number(value) : '';
}

function StudyTable({ table, requests }: { table: Row[]; requests: Request[] | undefined }) {
  const [whole, setWhole] = useState(false);
  const all = columnsOf(table);
  const further = all.length > furtherOf ? all.filter(({ name }) => !first.has(name)).length : 0;
  const columns = whole || further === 0 ? all : all.filter(({ name }) => first.has(name));
  const open = async (k: number): Promise<void> => {
    const { inputs } = requests![k]!;
    const packed = await pack({ process: 'field' in inputs ? 'apply' : 'solve', inputs });
    if (packed) goTo(`run/${'field' in inputs ? 'apply' : 'solve'}?r=${packed}&go=1`);
  };
  return (
    <>
      <div class="scroll" tabIndex={0} role="region" aria-label="Table of the study">
        <table class="numbers">
          <thead>
            <tr>
              {requests && <th scope="col"><span class="unseen">Look at it</span></th>}
              {columns.map(({ name, paper }) => (
                <th key={name + paper} scope="col" class={paper ? 'paper' : undefined} title={paper ? `${plain(name)} as the paper printed it` : first.get(name)}>{paper ? 'in the paper' : plain(name)}</th>
              ))}
            </tr>
          </thead>
          <tbody>
            {table.map((row, k) => (
              <tr key={k}>
                {requests && <td>{requests[k] && <button type="button" class="link" onClick={() => void open(k)}>look</button>}</td>}
                {columns.map((column) => <td key={column.name + column.paper} class={column.paper ? 'paper' : undefined}>{cell(row, column)}</td>)}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <div class="table-foot">
        <p class="hint">{columns.filter(({ name, paper }) => !paper && /^(rate|l2|linf)/.test(name) && first.has(name)).map(({ name }) => `${plain(name)}: ${first.get(name)}`).join(' · ')}</p>
        {further > 0 && <button type="button" class="quiet" aria-expanded={whole} onClick={() => setWhole(!whole)}>{whole ? 'Fewer columns' : some(further, 'further column')}</button>}
      </div>
    </>
  );
}

function plain(name: string): string {
  return name.replaceAll('_', ' ');
}

function Convergence({ table }: { table: Row[] }) {
  const usable = norms.filter(([name]) => table.filter((row) => (row[name] as number) > 0).length > 1);
  if (table.length < 2 || usable.length === 0) return null;
  const h = table.map(({ cells }) => 1 / cells);
  const curves: Curve[] = usable.map(([name, label]) => ({ label, x: h, y: table.map((row) => Number(row[name] ?? NaN)), marks: true }));
  const printed = usable.filter(([name]) => table.some(({ paper }) => paper?.[name] !== undefined));
  const papers: Curve[] = printed.map(([name, label]) => ({ label: `${label}, paper`, x: h, y: table.map(({ paper }) => paper?.[name] ?? NaN), marks: true, dashed: true }));
  const order = Math.max(1, Math.round(averageSlope(h, curves[0]!.y)));
  return (
    <div>
      <h3>Convergence</h3>
      <LinePlot title="Error over mesh size" curves={[...curves, ...papers]} x={{ label: 'h = 1 / cells', log: true }} y={{ label: 'error', log: true }} slopes={[order]} height={320} />
    </div>
  );
}

/** Slope of log error over log h, by least squares. */
function averageSlope(h: number[], error: ArrayLike<number>): number {
  const x = h.map(Math.log);
  const y = Array.from(error, Math.log);
  const mean = (list: number[]): number => list.reduce((sum, value) => sum + value, 0) / list.length;
  const [mx, my] = [mean(x), mean(y)];
  const above = x.reduce((sum, value, k) => sum + (value - mx) * (y[k]! - my), 0);
  const below = x.reduce((sum, value) => sum + (value - mx) ** 2, 0);
  return below > 0 ? above / below : 1;
}

function Sections({ name, title, table }: { name: string; title: string; table: Row[] }) {
  const found = table.filter((row) => row[name]);
  if (found.length === 0) return null;
  const curves = found.map((row): Curve => {
    const { x, value } = row[name] as Result;
    return { label: `${row.cells} cells`, x: flat(x), y: flat(value), marks: flat(x).length < 60 };
  });
  return <div><h3>{title}</h3><LinePlot title={title} curves={curves} x={{ label: 'x' }} y={{ label: 'solution' }} /></div>;
}

function Histories({ table }: { table: Row[] }) {
  const found = table.filter((row) => row.history);
  if (found.length === 0) return null;
  const curves = found.map((row): Curve => {
    const { t, l2 } = row.history as Result;
    return { label: `${row.cells} cells`, x: flat(t), y: flat(l2), marks: true };
  });
  return <div><h3>Error in time</h3><LinePlot title="Error in time" curves={curves} x={{ label: 't' }} y={{ label: 'root mean square', log: true }} /></div>;
}
