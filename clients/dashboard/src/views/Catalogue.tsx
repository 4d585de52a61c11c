/** Problems to begin with. */

import { useEffect, useRef } from 'preact/hooks';
import { cases, type Case } from '../lib/cases';
import { table } from '../lib/colour';
import { client, useAsked } from '../lib/daemon';

export function Catalogue() {
  const { value: processes } = useAsked(() => client.processes(), []);
  const known = (id: string): boolean => processes?.some((process) => process.id === id) ?? true;
  return (
    <main class="catalogue" id="main">
      <header class="intro">
        <h1>Partial differential equations on scattered points</h1>
        <p>Take a known problem and change it, or start with your own. Everything here is one request to this daemon, which you can take to the command line or to Python.</p>
      </header>
      <ul class="cards">
        {cases.map((one) => <li key={one.id}><CaseCard one={one} there={known(one.process)} /></li>)}
      </ul>
      <section class="own">
        <h2>A problem of your own</h2>
        <div class="row">
          {(processes ?? []).filter(({ id }) => id !== 'echo').map(({ id, title }) => (
            <a key={id} class="start" href={`#run/${id}`}><b>{id}</b><span>{title}</span></a>
          ))}
        </div>
      </section>
    </main>
  );
}

function CaseCard({ one, there }: { one: Case; there: boolean }) {
  return (
    <article class={`case${there ? '' : ' absent'}`}>
      <Sketch one={one} />
      <h2>{there ? <a href={`#run/${one.process}?case=${one.id}&go=1`}>{one.title}</a> : one.title}</h2>
      <p>{one.about}</p>
      <p class="case-foot">
        {there ? <a href={`#run/${one.process}?case=${one.id}`}>Edit</a> : <span>This daemon has no process “{one.process}”.</span>}
        {there && one.study && <a href={`#run/study?study=${one.study}`}>Study convergence</a>}
      </p>
    </article>
  );
}

/** The case as points in its colours, drawn from a formula. */
function Sketch({ one }: { one: Case }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const { width, height } = canvas.current!;
    const context = canvas.current!.getContext('2d')!;
    const colours = table('viridis');
    const step = 15;
    for (let j = 0; j * step < height; j++) {
      for (let i = 0; i * step < width; i++) {
        const wave = Math.sin(12.9898 * i + 78.233 * j) * 43758.5453;
        const jitter = [wave - Math.floor(wave), wave * 7 - Math.floor(wave * 7)];
        const [x, y] = [(i + 0.5 + 0.5 * (jitter[0]! - 0.5)) * step, (j + 0.5 + 0.5 * (jitter[1]! - 0.5)) * step];
        const value = one.sketch(x / width, 1 - y / height);
        if (Number.isNaN(value)) continue;
        const k = 4 * Math.round(255 * Math.min(1, Math.max(0, value)));
        context.fillStyle = `rgb(${colours[k]} ${colours[k + 1]} ${colours[k + 2]})`;
        context.beginPath();
        context.arc(x, y, 0.4 * step, 0, 2 * Math.PI);
        context.fill();
      }
    }
  }, [one]);
  return <canvas ref={canvas} width={600} height={270} aria-hidden="true" />;
}
