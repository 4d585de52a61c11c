/** The daemon's jobs, with filters; what runs is asked after once a second. */

import { useEffect, useState } from 'preact/hooks';
import { hasEnded, ProblemError, type JobList, type StatusInfo } from 'scatterd';
import { client, noticed, useAsked } from '../lib/daemon';
import { explain } from '../lib/run';
import { when } from '../lib/text';

const statuses = ['accepted', 'running', 'successful', 'failed', 'dismissed'];
const pageSize = 20;

type Loaded = { list?: JobList; error?: unknown };

function useJobs(status: string, process: string, page: number): [Loaded, () => void] {
  const [loaded, setLoaded] = useState<Loaded>({});
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout>;
    const stop = new AbortController();
    const load = async (): Promise<void> => {
      try {
        const query = { ...(status && { status }), ...(process && { processID: process }), limit: pageSize, offset: page * pageSize };
        const list = await client.jobs(query, { signal: stop.signal });
        setLoaded({ list });
        timer = setTimeout(load, list.jobs.some((job) => !hasEnded(job)) ? 1000 : 5000);
      } catch (error) {
        if (stop.signal.aborted) return;
        noticed(error);
        setLoaded((before) => (error instanceof ProblemError ? { error } : before));
        timer = setTimeout(load, 3000);
      }
    };
    void load();
    return () => {
      stop.abort();
      clearTimeout(timer);
    };
  }, [status, process, page, turn]);
  return [loaded, () => setTurn((n) => n + 1)];
}

export function Jobs() {
  const [status, setStatus] = useState('');
  const [process, setProcess] = useState('');
  const [page, setPage] = useState(0);
  const [{ list, error }, again] = useJobs(status, process, page);
  const { value: processes } = useAsked(() => client.processes(), []);
  const filter = (set: (value: string) => void) => (event: Event & { currentTarget: HTMLSelectElement }): void => {
    set(event.currentTarget.value);
    setPage(0);
  };
  const jobs = list?.jobs ?? [];
  return (
    <main class="jobs" id="main">
      <header class="jobs-head">
        <h1>Jobs</h1>
        <label class="pick"><span>Status</span>
          <select value={status} onChange={filter(setStatus)}><option value="">All</option>{statuses.map((name) => <option key={name}>{name}</option>)}</select>
        </label>
        <label class="pick"><span>Process</span>
          <select value={process} onChange={filter(setProcess)}><option value="">All</option>{(processes ?? []).map(({ id }) => <option key={id}>{id}</option>)}</select>
        </label>
      </header>
      {error !== undefined && <NoJobs error={error} />}
      {list && jobs.length === 0 && (
        <section class="card empty"><h2>No jobs</h2><p>{status || process ? 'None fits the filter.' : 'Choose “as a job” below a problem: the daemon then works on it by itself, and it appears here.'}</p></section>
      )}
      {!list && error === undefined && <p class="empty" aria-busy="true">Asking for the jobs …</p>}
      {jobs.length > 0 && (
        <div class="scroll card" tabIndex={0} role="region" aria-label="Jobs">
          <table class="job-list">
            <thead><tr>{['Job', 'Process', 'Status', 'Progress', 'Created', 'Finished'].map((name) => <th key={name} scope="col">{name}</th>)}<th scope="col"><span class="unseen">Actions</span></th></tr></thead>
            <tbody>{jobs.map((job) => <Row key={job.jobID} job={job} onChange={again} />)}</tbody>
          </table>
        </div>
      )}
      {(page > 0 || list?.more) && (
        <nav class="pages" aria-label="Pages">
          <button type="button" disabled={page === 0} onClick={() => setPage(page - 1)}>Newer</button>
          <span>Page {page + 1}</span>
          <button type="button" disabled={!list?.more} onClick={() => setPage(page + 1)}>Older</button>
        </nav>
      )}
    </main>
  );
}

function NoJobs({ error }: { error: unknown }) {
  if (error instanceof ProblemError && error.status === 404) {
    return <section class="card empty"><h2>This daemon keeps no jobs</h2><p>It solves while you wait; problems can still be posed and solved.</p></section>;
  }
  return <section class="card empty failure" role="alert"><h2>{explain(error).title}</h2><p>{explain(error).detail}</p></section>;
}

function Row({ job, onChange }: { job: StatusInfo; onChange: () => void }) {
  const [trouble, setTrouble] = useState('');
  const over = hasEnded(job);
  const dismiss = async (): Promise<void> => {
    try {
      await client.job(job.jobID).dismiss();
      onChange();
    } catch (error) {
      setTrouble(explain(error).detail);
    }
  };
  return (
    <tr>
      <td><a class="code" href={`#jobs/${job.jobID}`}>{job.jobID.slice(0, 13)}</a></td>
      <td>{job.processID}</td>
      <td><span class={`status status-${job.status}`}>{job.status}</span></td>
      <td>
        {over ? <span class="hint">{job.message}</span> : <progress max={100} value={job.progress} aria-label={`Progress of ${job.jobID}`} />}
        {!over && <span class="hint"> {job.message}</span>}
        {trouble && <span class="errors" role="alert">{trouble}</span>}
      </td>
      <td>{when(job.created)}</td>
      <td>{when(job.finished)}</td>
      <td>{job.status !== 'dismissed' && <button type="button" class="quiet" onClick={() => void dismiss()}>{over ? 'Delete' : 'Cancel'}</button>}</td>
    </tr>
  );
}
