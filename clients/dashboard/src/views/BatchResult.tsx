/** A batch: how far it is, and its requests with what became of each. */

import { useEffect, useState } from 'preact/hooks';
import { hasEnded, type StatusInfo } from 'scatterd';
import { client, noticed } from '../lib/daemon';
import { inShort, partOf } from '../lib/batch';
import type { Request } from '../lib/request';
import { explain } from '../lib/run';
import { count, seconds, some } from '../lib/text';

const pageSize = 50;

interface Loaded {
  info?: StatusInfo;
  /** Of the page, in the order of the batch. */
  parts: StatusInfo[];
  trouble?: string;
}

/** One page of the parts. The daemon lists the newest first, which is the last of the batch. */
async function load(id: string, page: number, signal: AbortSignal): Promise<Loaded> {
  const info = await client.job(id).status({ signal });
  const total = info.parts ?? 0;
  const limit = Math.min(pageSize, total - page * pageSize);
  if (limit <= 0) return { info, parts: [] };
  const offset = Math.max(0, total - page * pageSize - limit);
  const { jobs } = await client.jobs({ parent: id, limit, offset }, { signal });
  return { info, parts: jobs.reverse() };
}

/** Asked after once a second until the batch is over. */
function useBatch(id: string, page: number): Loaded {
  const [loaded, setLoaded] = useState<Loaded>({ parts: [] });
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout>;
    const stop = new AbortController();
    const ask = async (): Promise<void> => {
      try {
        const next = await load(id, page, stop.signal);
        setLoaded(next);
        if (!next.info || !hasEnded(next.info)) timer = setTimeout(ask, 1000);
      } catch (error) {
        if (stop.signal.aborted) return;
        noticed(error);
        setLoaded((before) => ({ ...before, trouble: explain(error).detail }));
        timer = setTimeout(ask, 3000);
      }
    };
    void ask();
    return () => {
      stop.abort();
      clearTimeout(timer);
    };
  }, [id, page]);
  return loaded;
}

export function BatchResult({ id, request, onCancel }: { id: string; request: Request | undefined; onCancel: () => void }) {
  const [page, setPage] = useState(0);
  const { info, parts, trouble } = useBatch(id, page);
  if (!info) return <section class="card empty" aria-busy="true">{trouble && <p class="errors" role="alert">{trouble}</p>}</section>;
  const pages = Math.ceil((info.parts ?? 0) / pageSize);
  return (
    <section class="card batch" aria-label="Batch">
      <header class="batch-head">
        <h2>Batch of {some(info.parts ?? parts.length, 'request')}</h2>
        <span class={`status status-${info.status}`}>{info.status}</span>
        <span class="spring" />
        {hasEnded(info)
          ? info.status === 'successful' && <a class="button" href={`jobs/${id}/results`} download={`batch-${id.slice(0, 8)}.json`}>Download all results</a>
          : <button type="button" onClick={onCancel}>Cancel all</button>}
      </header>
      {!hasEnded(info) && <progress max={100} value={info.progress} aria-label="Progress of the batch" />}
      <p class="hint" role="status">{info.message}</p>
      <div class="scroll" tabIndex={0} role="region" aria-label="Requests of the batch">
        <table class="job-list parts">
          <thead><tr>{['#', 'Process', 'Status', 'What came of it'].map((name) => <th key={name} scope="col">{name}</th>)}</tr></thead>
          <tbody>{parts.map((part, k) => <Row key={part.jobID} batch={id} k={page * pageSize + k} part={part} request={request} />)}</tbody>
        </table>
      </div>
      {pages > 1 && (
        <nav class="pages" aria-label="Pages">
          <button type="button" disabled={page === 0} onClick={() => setPage(page - 1)}>Back</button>
          <span>{page + 1} of {count(pages)}</span>
          <button type="button" disabled={page + 1 >= pages} onClick={() => setPage(page + 1)}>On</button>
        </nav>
      )}
    </section>
  );
}

function Row({ batch, k, part, request }: { batch: string; k: number; part: StatusInfo; request: Request | undefined }) {
  const { cloud: _, parameters, ...asked } = partOf(request, k)?.inputs ?? {};
  const about = inShort({ ...(parameters as object), ...asked });
  return (
    <tr>
      <td>{k + 1}</td>
      <td><a href={`#jobs/${part.jobID}?batch=${batch}&part=${k}`} aria-label={`Request ${k + 1}, ${part.processID}`}>{part.processID}</a></td>
      <td><span class={`status status-${part.status}`}>{part.status}</span></td>
      <td>
        {part.status === 'running' && <progress max={100} value={part.progress} aria-label={`Progress of request ${k + 1}`} />}
        <span class={part.status === 'failed' ? 'errors' : 'hint'}>{toldBy(part)}</span>
        {about && <span class="hint about-part">{about}</span>}
      </td>
    </tr>
  );
}

function toldBy({ status, message, started, finished }: StatusInfo): string {
  if (status !== 'successful' || !started || !finished) return message ?? '';
  return `done in ${seconds((Date.parse(finished) - Date.parse(started)) / 1000)}`;
}
