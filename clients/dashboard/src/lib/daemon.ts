/** The daemon that served this page, and whether it answers. */

import { useEffect, useState } from 'preact/hooks';
import { Client, ProblemError, UnreachableError, type ProcessDescription } from 'scatterd';

export const client = new Client(new URL('.', document.baseURI.split('#')[0]));
export const base = client.base.href;

type Listener = (there: boolean) => void;
const listeners = new Set<Listener>();
let there = true;
let timer: ReturnType<typeof setTimeout> | undefined;

function tell(now: boolean): void {
  if (now === there) return;
  there = now;
  for (const listener of listeners) listener(now);
}

/** Asks until the daemon answers; `after` in milliseconds. */
function watch(after: number): void {
  clearTimeout(timer);
  timer = setTimeout(async () => {
    const ready = await client.get('readyz').then(() => true, () => false);
    tell(ready);
    watch(ready ? 15_000 : 1_500);
  }, after);
}

/** To be called with whatever a call threw: an unreachable daemon is noticed at once. */
export function noticed(error: unknown): void {
  if (error instanceof UnreachableError) {
    tell(false);
    watch(1_000);
  }
}

export function useDaemon(): boolean {
  const [now, setNow] = useState(there);
  useEffect(() => {
    listeners.add(setNow);
    watch(15_000);
    return () => void listeners.delete(setNow);
  }, []);
  return now;
}

// ---- Descriptions, asked for once ----

const descriptions = new Map<string, Promise<ProcessDescription>>();

export function describe(process: string): Promise<ProcessDescription> {
  let found = descriptions.get(process);
  if (!found) {
    found = client.process(process);
    found.catch(() => descriptions.delete(process));
    descriptions.set(process, found);
  }
  return found;
}

let jobs: Promise<boolean> | undefined;

/** Does this daemon know jobs? */
export function hasJobs(): Promise<boolean> {
  jobs ??= client.jobs({ limit: 1 }).then(
    () => true,
    (error) => {
      if (!(error instanceof ProblemError && error.status === 404)) jobs = undefined;
      return false;
    },
  );
  return jobs;
}

/** A value that is asked for; asked again when `keys` change or the daemon comes back. */
export function useAsked<Value>(ask: () => Promise<Value>, keys: unknown[]): { value?: Value; error?: unknown } {
  const [state, setState] = useState<{ value?: Value; error?: unknown }>({});
  const up = useDaemon();
  useEffect(() => {
    let current = true;
    ask().then(
      (value) => current && setState({ value }),
      (error) => {
        noticed(error);
        if (current) setState({ error });
      },
    );
    return () => {
      current = false;
    };
  }, [...keys, up]);
  return state;
}
