/** One run of a problem: now while one waits, or as a job. */

import { useEffect, useRef, useState } from 'preact/hooks';
import { ProblemError, type Job, type JobEvent } from 'scatterd';
import { client, noticed } from './daemon';
import type { Request } from './request';
import type { Result } from './scene';
import { rememberJob } from './memory';

export type Run =
  | { state: 'idle' }
  | { state: 'running'; since: number; process?: string; job?: string; progress?: number; message?: string; residuals: number[] }
  | { state: 'done'; request: Request; result: Result; seconds: number; job?: string }
  | { state: 'failed'; error: unknown; job?: string };

export interface Runner {
  run: Run;
  start: (request: Request, asJob: boolean) => void;
  follow: (id: string, request: Request | undefined) => void;
  cancel: () => void;
}

/** What an event of a job tells about it. */
function heard(run: Run, { type, data }: JobEvent): Run {
  if (run.state !== 'running') return run;
  const progress = typeof data.progress === 'number' ? data.progress : run.progress;
  const message = [data.message, data.phase, type === 'phase' ? data.value : undefined].find((text) => typeof text === 'string');
  const residual = typeof data.residual === 'number' ? [...run.residuals, data.residual] : run.residuals;
  const process = typeof data.processID === 'string' ? data.processID : run.process;
  return { ...run, ...(progress !== undefined && { progress }), ...(process && { process }), message: (message as string) ?? run.message ?? '', residuals: residual };
}

export function useRunner(): Runner {
  const [run, setRun] = useState<Run>({ state: 'idle' });
  const current = useRef<{ stop: AbortController; job?: Job }>();

  useEffect(() => () => current.current?.stop.abort(), []);

  /** Starts something in place of what ran before; only the latest may say how it ended. */
  const begin = (act: (stop: AbortSignal, handle: { job?: Job }) => Promise<Run>, first: Partial<Run> = {}): void => {
    current.current?.stop.abort();
    const mine: { stop: AbortController; job?: Job } = { stop: new AbortController() };
    current.current = mine;
    setRun({ state: 'running', since: Date.now(), residuals: [], ...first } as Run);
    act(mine.stop.signal, mine).then(
      (next) => current.current === mine && setRun(next),
      (error) => {
        noticed(error);
        if (current.current !== mine) return;
        setRun(mine.stop.signal.aborted ? { state: 'idle' } : { state: 'failed', error });
      },
    );
  };

  const watch = async (job: Job, request: Request | undefined, stop: AbortSignal, since: number): Promise<Run> => {
    for await (const event of job.events({ signal: stop })) setRun((run) => heard(run, event));
    const known = request ?? { process: (await job.status({ signal: stop })).processID ?? 'solve', inputs: {} };
    const isBatch = known.process === 'batch'; // its parts are shown, each with its own result
    const result = isBatch ? {} : await job.results<Result>({ signal: stop });
    return { state: 'done', request: known, result, seconds: (Date.now() - since) / 1000, job: job.id };
  };

  return {
    run,
    start: (request, asJob) => begin(async (stop, mine) => {
      const since = performance.now();
      if (asJob) {
        const job = await client.submit(request.process, request.inputs, { signal: stop });
        mine.job = job;
        rememberJob(job.id, request);
        setRun((run) => ({ ...run, job: job.id, process: request.process }) as Run);
        return watch(job, request, stop, Date.now());
      }
      const result = await client.execute(request.process, request.inputs, { signal: stop });
      return { state: 'done', request, result, seconds: (performance.now() - since) / 1000 };
    }),
    follow: (id, request) => begin(async (stop, mine) => {
      mine.job = client.job(id);
      return watch(mine.job, request, stop, Date.now());
    }, { job: id } as Partial<Run>),
    cancel: () => {
      const { job, stop } = current.current ?? {};
      if (job) void job.dismiss().catch((error) => noticed(error));
      stop?.abort();
    },
  };
}

/** What to say when something failed, and which values are to blame. */
export function explain(error: unknown): { title: string; detail: string; errors: { pointer: string; detail: string }[] } {
  if (error instanceof ProblemError) return { title: error.title, detail: error.detail, errors: [...error.errors] };
  return { title: 'That did not work', detail: (error as Error)?.message ?? String(error), errors: [] };
}
