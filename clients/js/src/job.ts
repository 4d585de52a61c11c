/** A job: an execution that goes on without a connection. */

import type { Client, CallOptions } from './client.js';
import { ProblemError, UnreachableError } from './errors.js';
import { readEvents, type StreamState } from './sse.js';
import type { JobStatus, StatusInfo } from './types.js';

/** What a running job tells: a change of status, progress from 0 to 100, a phase, a residual. */
export interface JobEvent {
  type: string;
  id: string;
  data: Record<string, unknown>;
}

export interface WaitOptions extends CallOptions {
  onEvent?: (event: JobEvent) => void;
}

const ended: readonly JobStatus[] = ['successful', 'failed', 'dismissed'];

export function hasEnded(info: StatusInfo): boolean {
  return ended.includes(info.status);
}

export class Job {
  constructor(
    private readonly client: Client,
    readonly id: string,
  ) {}

  private get path(): string {
    return `jobs/${encodeURIComponent(this.id)}`;
  }

  status(options: CallOptions = {}): Promise<StatusInfo> {
    return this.client.get<StatusInfo>(this.path, options);
  }

  /** Results of a successful job; the job's own problem is thrown if it failed. */
  results<Result = Record<string, unknown>>(options: CallOptions = {}): Promise<Result> {
    return this.client.results<Result>(`${this.path}/results`, options);
  }

  /** Stops the job, or drops its results. */
  async dismiss(options: CallOptions = {}): Promise<StatusInfo> {
    const reply = await this.client.call('DELETE', this.path, options);
    return (await reply.json()) as StatusInfo;
  }

  /** Events until the job has ended. A broken connection, or a daemon that is restarted, is
   *  connected to again, from the event after the last one seen. */
  async *events(options: CallOptions = {}): AsyncGenerator<JobEvent> {
    const state: StreamState = { lastId: '', retry: 1000 };
    for (;;) {
      for await (const event of this.connection(state, options)) {
        yield event;
        if (tellsEnd(event)) return;
      }
      const info = await this.lastWord(state, options);
      if (info && hasEnded(info)) {
        yield { type: 'status', id: state.lastId, data: { ...info } };
        return;
      }
      await sleep(state.retry, options.signal);
    }
  }

  /** Events of one connection, none if there is nobody to connect to. */
  private async *connection(state: StreamState, options: CallOptions): AsyncGenerator<JobEvent> {
    const headers: Record<string, string> = { Accept: 'text/event-stream' };
    if (state.lastId) headers['Last-Event-ID'] = state.lastId;
    try {
      const reply = await this.client.call('GET', `${this.path}/events`, { ...options, headers });
      if (!reply.body) return;
      for await (const { type, data, id } of readEvents(reply.body, state, options.signal)) {
        yield { type, id, data: parse(data) };
      }
    } catch (error) {
      if (options.signal?.aborted) throw options.signal.reason;
      if (error instanceof ProblemError && !isPassing(error)) throw error;
    }
  }

  /** The status after a connection has ended; nothing while the daemon is away. */
  private async lastWord(state: StreamState, options: CallOptions): Promise<StatusInfo | undefined> {
    try {
      const info = await this.status(options);
      state.retry = Math.min(state.retry, 1000);
      return info;
    } catch (error) {
      if (!isPassing(error)) throw error;
      state.retry = Math.min(2 * state.retry, 10_000);
      return undefined;
    }
  }

  /** Waits for the end and returns the results. */
  async wait<Result = Record<string, unknown>>(options: WaitOptions = {}): Promise<Result> {
    for await (const event of this.events(options)) options.onEvent?.(event);
    return this.results<Result>(options);
  }
}

function tellsEnd({ type, data }: JobEvent): boolean {
  return type === 'status' && ended.includes(data['status'] as JobStatus);
}

function parse(data: string): Record<string, unknown> {
  try {
    const value: unknown = JSON.parse(data);
    return typeof value === 'object' && value !== null ? { ...value } : { value };
  } catch {
    return { value: data };
  }
}

/** Will it be different in a while? */
function isPassing(error: unknown): boolean {
  return error instanceof UnreachableError || (error instanceof ProblemError && [429, 503].includes(error.status));
}

function sleep(milliseconds: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, milliseconds);
    signal?.addEventListener('abort', () => {
      clearTimeout(timer);
      reject(signal.reason);
    }, { once: true });
  });
}
