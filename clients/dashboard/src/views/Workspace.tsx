/** One problem: to the left what is asked, to the right what came of it. */

import { useEffect, useRef, useState } from 'preact/hooks';
import type { ProcessDescription, ProcessSummary } from 'scatterd';
import { Editor } from '../form/Editor';
import type { CloudValue } from '../lib/cloudfile';
import { partOf } from '../lib/batch';
import { caseOf, startOf } from '../lib/cases';
import { base, client, describe, hasJobs, useAsked } from '../lib/daemon';
import { firstLook, readLook, writeLook, type Look } from '../lib/look';
import { draftOf, rememberDraft, requestOfJob } from '../lib/memory';
import { pack, unpack, type Request } from '../lib/request';
import { goTo, type Route } from '../lib/route';
import { explain, useRunner, type Runner } from '../lib/run';
import { sceneOfCloud } from '../lib/scene';
import { seconds } from '../lib/text';
import { Picture } from '../picture/Picture';
import { plainName } from '../form/Field';
import { LinePlot } from '../plots/LinePlot';
import { BatchResult } from './BatchResult';
import { Result } from './Result';

/** What a route asks for: a request out of the link, a case, a remembered draft, or a start. */
async function requestOf({ path, query }: Route): Promise<Request | undefined> {
  const packed = query.get('r');
  if (packed) return unpack(packed);
  if (path[0] === 'jobs') return requestOfJob(path[1] ?? '') ?? partOf(requestOfJob(query.get('batch') ?? ''), Number(query.get('part')));
  const known = caseOf(query.get('case'));
  if (known) return structuredClone({ process: known.process, inputs: known.inputs });
  const process = path[1] ?? 'solve';
  const study = query.get('study');
  if (study) return { process, inputs: { case: study } };
  return draftOf(process) ?? { process, inputs: startOf(process) };
}

export function Workspace({ route }: { route: Route }) {
  const key = `${route.path.join('/')}?${['r', 'case', 'study'].map((name) => route.query.get(name) ?? '').join('&')}`;
  const { value: processes } = useAsked(() => client.processes(), []);
  const [request, setRequest] = useState<Request>(); // none: of a job that another browser asked for
  const [opened, setOpened] = useState<string>();
  const [look, setLook] = useState<Look>(firstLook);
  const runner = useRunner();
  const job = route.path[0] === 'jobs' ? route.path[1] : undefined;

  useEffect(() => {
    let current = true;
    void requestOf(route).then((found) => {
      if (!current) return;
      setRequest(found);
      setOpened(key);
      setLook(readLook(route.query));
      if (job) runner.follow(job, found);
      else if (found && route.query.has('go')) runner.start(found, false);
    }, () => { setRequest({ process: 'solve', inputs: startOf('solve') }); setOpened(key); });
    return () => {
      current = false;
    };
  }, [key]);

  const outcome = useRef<HTMLDivElement>(null);
  const { state } = runner.run;
  useEffect(() => {
    const below = matchMedia('(max-width: 860px)').matches;
    if (below && (state === 'done' || state === 'running')) outcome.current?.scrollIntoView({ block: 'start' });
  }, [state]);

  const change = (next: Request): void => {
    setRequest(next);
    rememberDraft(next);
  };
  if (opened === undefined) return <p class="empty">Opening …</p>;
  return (
    <main class="workspace" id="main">
      {request
        ? <Problem request={request} processes={processes ?? []} runner={runner} onChange={change} look={look} />
        : <NotKnown />}
      <div class="outcome" ref={outcome}><Outcome runner={runner} request={request} look={look} onLook={setLook} /></div>
    </main>
  );
}

// ---- To the left ----

/** In place of the form of a job whose request is not known here. */
function NotKnown() {
  return (
    <section class="problem not-known" aria-label="Problem">
      <h2>What was asked is not known here</h2>
      <p class="hint">The daemon keeps the results of a job; what was asked is kept by the browser or program that asked, and by links that were copied from it.</p>
      <p><a href="#run/solve">Pose a problem</a> · <a href="#jobs">All jobs</a></p>
    </section>
  );
}

interface ProblemProps {
  request: Request;
  processes: ProcessSummary[];
  runner: Runner;
  look: Look;
  onChange: (request: Request) => void;
}

function Problem({ request, processes, runner, look, onChange }: ProblemProps) {
  const { value: description, error } = useAsked(() => describe(request.process), [request.process]);
  const { value: jobs } = useAsked(hasJobs, []);
  const [asJob, setAsJob] = useState(false);
  const { run } = runner;
  const errors = run.state === 'failed' ? explain(run.error).errors : [];
  const submit = (event: Event): void => {
    event.preventDefault();
    runner.start(request, alwaysJob || (asJob && jobs === true));
  };
  const fits = description?.id === request.process;
  const alwaysJob = fits && description.jobControlOptions?.includes('sync-execute') === false;
  return (
    <form class="problem" aria-label="Problem" onSubmit={submit} onKeyDown={(event) => { if (event.key === 'Enter' && (event.ctrlKey || event.metaKey)) submit(event); }}>
      <div class="problem-head">
        <label class="pick"><span>Process</span>
          <select value={request.process} onChange={(event) => goTo(`run/${event.currentTarget.value}`)}>
            {!processes.some(({ id }) => id === request.process) && <option value={request.process}>{request.process}</option>}
            {processes.map(({ id }) => <option key={id} value={id}>{id}</option>)}
          </select>
        </label>
        {fits && <p class="hint">{description.title}</p>}
      </div>
      <div class="problem-body">
        {error !== undefined && <Missing process={request.process} error={error} />}
        {fits && <Editor description={description as ProcessDescription} request={request} errors={errors} onChange={onChange} />}
      </div>
      <div class="problem-foot">
        {/* with keys: the button clicked must not turn into the other while it is being clicked */}
        {run.state === 'running'
          ? <button key="cancel" type="button" class="main danger" onClick={runner.cancel}>Cancel</button>
          : <button key="solve" type="submit" class="main" disabled={!fits || (alwaysJob && jobs === false)} title="Ctrl + Enter">{alwaysJob ? 'Submit' : 'Solve'}</button>}
        {jobs
          ? !alwaysJob && <label class="toggle" title="The daemon works on it by itself and keeps the result; this page may be closed meanwhile"><input type="checkbox" checked={asJob} onChange={(event) => setAsJob(event.currentTarget.checked)} /> as a job</label>
          : jobs === false && <span class="hint">This daemon keeps no jobs</span>}
        <span class="spring" />
        <CopyLink request={request} look={look} run={run} />
      </div>
    </form>
  );
}

function Missing({ process, error }: { process: string; error: unknown }) {
  return <p class="errors" role="alert">The process “{process}” is not to be had: {explain(error).detail}</p>;
}

/** A link that brings back problem, result and view. */
function CopyLink({ request, look, run }: { request: Request; look: Look; run: Runner['run'] }) {
  const [said, setSaid] = useState('');
  const copy = async (): Promise<void> => {
    const query = new URLSearchParams();
    const packed = await pack(request);
    const job = run.state === 'done' ? run.job : undefined;
    if (packed) query.set('r', packed);
    writeLook(look, query);
    if (!packed && !job) {
      setSaid('Too large for a link');
      return;
    }
    if (run.state === 'done' && !job) query.set('go', '1');
    await navigator.clipboard.writeText(`${base}#${job ? `jobs/${job}` : `run/${request.process}`}?${query}`);
    setSaid('Copied');
    setTimeout(() => setSaid(''), 2500);
  };
  return <button type="button" class="quiet" onClick={() => void copy()}>{said || 'Copy link'}</button>;
}

// ---- To the right ----

function Outcome({ runner, request, look, onLook }: { runner: Runner; request: Request | undefined; look: Look; onLook: (look: Look) => void }) {
  const { run } = runner;
  const batch = batchOf(run);
  if (batch) return <BatchResult key={batch} id={batch} request={run.state === 'done' ? run.request : request} onCancel={runner.cancel} />;
  if (run.state === 'running') return <Progress run={run} onCancel={runner.cancel} />;
  if (run.state === 'failed') return <Failure error={run.error} />;
  if (run.state === 'done') return <Result request={run.request} result={run.result} seconds={run.seconds} look={look} onLook={onLook} />;
  return <Preview request={request} />;
}

/** The job of a run that is a batch. */
function batchOf(run: Runner['run']): string | undefined {
  if (run.state === 'running' && run.process === 'batch') return run.job;
  return run.state === 'done' && run.request.process === 'batch' ? run.job : undefined;
}

function Progress({ run, onCancel }: { run: Extract<Runner['run'], { state: 'running' }>; onCancel: () => void }) {
  const [now, setNow] = useState(Date.now());
  useEffect(() => {
    const timer = setInterval(() => setNow(Date.now()), 200);
    return () => clearInterval(timer);
  }, []);
  const elapsed = Math.max(0, now - run.since) / 1000;
  if (elapsed < 0.3 && !run.job) return <section class="card empty" aria-busy="true" />;
  return (
    <section class="card empty running" aria-label="Running" aria-busy="true">
      <h2>{run.job ? 'The job is running' : 'Solving'}</h2>
      <progress max={100} value={run.progress} aria-label="Progress" />
      <p role="status">{[run.progress !== undefined && `${Math.round(run.progress)} %`, run.message, seconds(Math.round(elapsed * 10) / 10)].filter(Boolean).join(' · ')}</p>
      {run.residuals.length > 2 && (
        <LinePlot title="Residual" curves={[{ label: 'residual', x: run.residuals.map((_, k) => k), y: run.residuals }]} x={{ label: 'report' }} y={{ label: 'residual', log: true }} height={180} />
      )}
      <button type="button" onClick={onCancel}>Cancel</button>
    </section>
  );
}

function Failure({ error }: { error: unknown }) {
  const { title, detail, errors } = explain(error);
  const several = errors.length === 1 ? 'One value is' : `${errors.length} values are`;
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus({ preventScroll: true }), [error]);
  return (
    <section class="card empty failure" role="alert">
      <h2 tabIndex={-1} ref={heading}>{errors.length > 0 ? 'The daemon cannot take this problem' : title}</h2>
      <p>{errors.length > 0 ? `${several} wrong, and marked in the form.` : detail}</p>
    </section>
  );
}

/** Before anything was solved: the points, if they are of one's own. */
function Preview({ request }: { request: Request | undefined }) {
  if (!request) return <section class="card empty" />;
  const cloud = request.inputs.cloud as CloudValue | undefined;
  if (cloud?.points && typeof cloud.points === 'object' && 'data' in cloud.points) {
    const scene = sceneOfCloud(cloud.points, cloud.groups);
    return <CloudPreview key={String(scene.count)} scene={scene} />;
  }
  return (
    <section class="card empty">
      <svg viewBox="0 0 120 60" class="dots" aria-hidden="true">
        {Array.from({ length: 60 }, (_, k) => <circle key={k} cx={6 + (k % 12) * 9.8 + 3 * Math.sin(k * 7)} cy={6 + Math.floor(k / 12) * 12 + 3 * Math.cos(k * 5)} r="1.6" />)}
      </svg>
      <h2>{plainName(request.process)}</h2>
      {request.process === 'batch'
        ? <p>List the requests and press Submit: how far each of them is, and its result, is found here.</p>
        : <p>Set up the problem and press Solve: what comes out is drawn here.</p>}
      <p class="hint"><kbd>Ctrl</kbd> + <kbd>Enter</kbd> does the same from any field.</p>
    </section>
  );
}

function CloudPreview({ scene }: { scene: ReturnType<typeof sceneOfCloud> }) {
  const [values, setValues] = useState<Float64Array>();
  const field = scene.fields[0]!;
  useEffect(() => void field.values(0).then(setValues), [scene]);
  const most = values ? Math.max(1, values.reduce((a, b) => Math.max(a, b), 0)) : 1;
  if (scene.dim === 1) return <section class="card empty"><p>{scene.count} points on a line, to be solved on.</p></section>;
  return (
    <section class="card stage" aria-label="Picture">
      <Picture scene={scene} field={field} values={values} range={[0, most]} map="viridis" look={{ ...firstLook, cells: false }} tool="move"
        onCut={() => undefined} onView={() => undefined} onRange={() => undefined} onCamera={() => undefined} />
      <p class="stage-foot">The cloud as it was dropped, coloured by group</p>
    </section>
  );
}
