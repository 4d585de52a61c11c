/** What was recorded in time. */

import { flat, matrix, rangeOf, type Result } from '../lib/scene';
import { LinePlot, type Curve } from './LinePlot';

export function HistoryPlot({ history }: { history: Result }) {
  const t = flat(history.t);
  const errors = (['l2', 'linf'] as const).filter((name) => history[name] !== undefined);
  const rows = matrix(history.solution);
  const extremes = Array.from({ length: rows.length }, (_, k) => rangeOf(rows.row(k)));
  const bounds: Curve[] = [
    { label: 'greatest value', x: t, y: extremes.map(([, greatest]) => greatest), marks: true },
    { label: 'least value', x: t, y: extremes.map(([least]) => least), marks: true },
  ];
  const norms: Curve[] = errors.map((name) => ({ label: name === 'l2' ? 'error, root mean square' : 'error, maximum', x: t, y: flat(history[name]), marks: true }));
  return (
    <div class="plots">
      <LinePlot title="Bounds of the solution in time" curves={bounds} x={{ label: 't' }} y={{ label: 'solution' }} />
      {norms.length > 0 && <LinePlot title="Error in time" curves={norms} x={{ label: 't' }} y={{ label: 'error', log: true }} />}
    </div>
  );
}
