/** The daemon's HTTP interface as functions. */

import { problemOf, UnreachableError } from './errors.js';
import { Job } from './job.js';
import { isNumbers, NdArray } from './ndarray.js';
import { decode, encode, mediaTypes, unwrap, type Format } from './wire.js';
import type {
  ProcessDescription,
  ProcessSummary,
  SolveInputs,
  SolveResult,
  StatusInfo,
} from './types.js';

export interface ClientOptions {
  /** Encoding of bodies, both ways. CBOR by default: numbers arrive as typed arrays. */
  format?: Format;
  /** Secret of a token, if the daemon wants one. A page that the daemon served needs none: the browser
   *  asks for name and secret and sends them. */
  token?: string;
  /** Sent with every request. */
  headers?: Record<string, string>;
  /** A fetch of your own. */
  fetch?: typeof fetch;
}

export interface CallOptions {
  signal?: AbortSignal;
  headers?: Record<string, string>;
  body?: BodyInit | Uint8Array;
}

export interface ExecuteOptions extends CallOptions {
  /** Outputs wanted; left out: all there are. */
  outputs?: readonly string[];
}

export interface JobQuery {
  status?: string | readonly string[];
  processID?: string | readonly string[];
  /** The parts of this batch; left out: all but parts. */
  parent?: string;
  limit?: number;
  offset?: number;
}

export interface JobList {
  jobs: StatusInfo[];
  /** Is there a next page? */
  more: boolean;
}

export class Client {
  readonly base: URL;
  private readonly format: Format;
  private readonly headers: Record<string, string>;
  private readonly fetch: typeof fetch;

  /** @param url address of the daemon, such as http://127.0.0.1:8480 */
  constructor(url: string | URL, options: ClientOptions = {}) {
    this.base = new URL(url);
    if (!this.base.pathname.endsWith('/')) this.base.pathname += '/';
    this.format = options.format ?? 'cbor';
    const known: Record<string, string> = options.token ? { Authorization: `Bearer ${options.token}` } : {};
    this.headers = { ...known, ...options.headers };
    this.fetch = options.fetch ?? ((input, init) => globalThis.fetch(input, init));
  }

  /** One HTTP request. Throws ProblemError for any status that is not 2xx. */
  async call(method: string, path: string, options: CallOptions = {}): Promise<Response> {
    const { signal, headers, body } = options;
    let reply: Response;
    try {
      reply = await this.fetch(new URL(path, this.base), {
        method,
        headers: { ...this.headers, ...headers },
        ...(signal && { signal }),
        ...(body !== undefined && { body: body as BodyInit }),
      });
    } catch (error) {
      if (signal?.aborted) throw signal.reason; // fetch of Node 18 has an error of its own for it
      throw new UnreachableError(`${this.base.origin} does not answer`, { cause: error });
    }
    if (!reply.ok) throw await problemOf(reply);
    return reply;
  }

  /** GET of a JSON document. */
  async get<Document>(path: string, options: CallOptions = {}): Promise<Document> {
    const headers = { Accept: 'application/json', ...options.headers };
    const reply = await this.call('GET', path, { ...options, headers });
    return (await reply.json()) as Document;
  }

  async processes(options: CallOptions = {}): Promise<ProcessSummary[]> {
    const list = await this.get<{ processes: ProcessSummary[] }>('processes', options);
    return list.processes;
  }

  process(id: string, options: CallOptions = {}): Promise<ProcessDescription> {
    return this.get<ProcessDescription>(`processes/${encodeURIComponent(id)}`, options);
  }

  /** Solves while you wait; aborting the signal stops the solve. */
  solve(inputs: SolveInputs, options: ExecuteOptions = {}): Promise<SolveResult> {
    return this.execute<SolveResult>('solve', { ...inputs }, options);
  }

  /** Runs any process while you wait. */
  async execute<Result = Record<string, unknown>>(
    process: string,
    inputs: Record<string, unknown>,
    options: ExecuteOptions = {},
  ): Promise<Result> {
    const reply = await this.post(process, inputs, options);
    return (await this.decoded(reply)) as Result;
  }

  /** Starts a job and returns as soon as the daemon has accepted it. */
  async submit(
    process: string,
    inputs: Record<string, unknown>,
    options: ExecuteOptions = {},
  ): Promise<Job> {
    const headers = { ...options.headers, Prefer: 'respond-async', Accept: 'application/json' };
    const reply = await this.post(process, inputs, { ...options, headers });
    const info = (await reply.json()) as Partial<StatusInfo>;
    if (reply.status !== 201 || !info.jobID) {
      throw new Error('this daemon knows no jobs: it answered at once');
    }
    return new Job(this, info.jobID);
  }

  /** A job by its identifier. */
  job(id: string): Job {
    return new Job(this, id);
  }

  async jobs(query: JobQuery = {}, options: CallOptions = {}): Promise<JobList> {
    const filter = new URLSearchParams();
    for (const [name, value] of Object.entries(query)) {
      for (const one of [value].flat()) filter.append(name, String(one));
    }
    const path = filter.size ? `jobs?${filter}` : 'jobs';
    const list = await this.get<{ jobs: StatusInfo[]; links?: { rel?: string }[] }>(path, options);
    return { jobs: list.jobs, more: (list.links ?? []).some(({ rel }) => rel === 'next') };
  }

  /** Keeps an array or a cloud at the daemon, to be used as `{href}` in many requests. */
  async upload(data: unknown, options: CallOptions = {}): Promise<{ href: string }> {
    const value = isNumbers(data) || data instanceof NdArray ? data : { ...(data as object) };
    const reply = await this.call('POST', 'data', this.bodied(value, options));
    const location = reply.headers.get('Location');
    const { href } = (await reply.json()) as { href?: string };
    const found = href ?? location;
    if (!found) throw new Error('the daemon kept the data but did not say where');
    return { href: new URL(found, this.base).pathname };
  }

  /** GET of a result document, with its objects taken out of `value`. */
  async results<Result>(path: string, options: CallOptions = {}): Promise<Result> {
    const headers = { Accept: mediaTypes[this.format], ...options.headers };
    return (await this.decoded(await this.call('GET', path, { ...options, headers }))) as Result;
  }

  private post(
    process: string,
    inputs: Record<string, unknown>,
    { outputs, ...options }: ExecuteOptions,
  ): Promise<Response> {
    const body: Record<string, unknown> = { inputs };
    if (outputs) body['outputs'] = Object.fromEntries(outputs.map((name) => [name, {}]));
    const path = `processes/${encodeURIComponent(process)}/execution`;
    return this.call('POST', path, this.bodied(body, options));
  }

  /** The options of a call with this value as body, in the client's format. */
  private bodied(value: unknown, options: CallOptions): CallOptions {
    const type = mediaTypes[this.format];
    const headers = { 'Content-Type': type, Accept: type, ...options.headers };
    return { ...options, headers, body: encode(value, this.format) };
  }

  private async decoded(reply: Response): Promise<unknown> {
    const bytes = new Uint8Array(await reply.arrayBuffer());
    return unwrap(decode(bytes, reply.headers.get('Content-Type') ?? mediaTypes.json));
  }
}
