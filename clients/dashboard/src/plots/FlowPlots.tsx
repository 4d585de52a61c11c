/** Profiles and histories of a flow. */

import { flat, type Result } from '../lib/scene';
import { number } from '../lib/text';
import { LinePlot } from './LinePlot';

function curve(label: string, x: unknown, y: unknown) {
  return { label, x: flat(x), y: flat(y) };
}

/** The members of an object that are arrays as long as `along`. */
function series(of: Result, along: string): [string, Float64Array][] {
  const length = (of[along] as ArrayLike<number> | undefined)?.length ?? 0;
  return Object.entries(of)
    .filter(([name, value]) => name !== along && (value as ArrayLike<number>)?.length === length && length > 0)
    .map(([name, value]) => [name, flat(value)]);
}

export function FlowPlots({ result }: { result: Result }) {
  const profiles = (result.profiles ?? {}) as Record<string, Result>;
  const history = (result.history ?? {}) as Result;
  const sections = (profiles.sections ?? []) as unknown as Result[];
  return (
    <div class="plots">
      {profiles.u?.y !== undefined && (
        <LinePlot title="u along the vertical centreline" curves={[curve('u', profiles.u.u, profiles.u.y)]} x={{ label: 'u' }} y={{ label: 'y' }} />
      )}
      {profiles.v?.x !== undefined && (
        <LinePlot title="v along the horizontal centreline" curves={[curve('v', profiles.v.x, profiles.v.v)]} x={{ label: 'x' }} y={{ label: 'v' }} />
      )}
      {sections.length > 0 && (
        <LinePlot title="u over the height, behind the step" x={{ label: 'u' }} y={{ label: 'y' }}
          curves={sections.slice(0, 6).map((section) => curve(`x = ${number(Number(section.x))}`, section.u, section.y))} />
      )}
      {series(history, 't').map(([name, values]) => (
        <LinePlot key={name} title={`${name} in time`} curves={[{ label: name, x: flat(history.t), y: values }]} x={{ label: 't' }} y={{ label: name.replaceAll('_', ' ') }} height={200} />
      ))}
    </div>
  );
}
