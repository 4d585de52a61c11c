/** What can go wrong: the daemon says why (RFC 9457), or nobody answers. */

export interface Culprit {
  /** JSON Pointer to the value in the request, such as /inputs/cloud/points/3. */
  pointer: string;
  detail: string;
}

export interface Problem {
  type: string;
  title: string;
  status: number;
  detail?: string;
  errors?: Culprit[];
}

/** The daemon refused or failed. */
export class ProblemError extends Error {
  override readonly name = 'ProblemError';
  readonly status: number;
  readonly title: string;
  readonly detail: string;
  readonly errors: readonly Culprit[];

  constructor(
    readonly problem: Problem,
    /** Seconds after which it makes sense to ask again, if the daemon told. */
    readonly retryAfter?: number,
  ) {
    super([problem.title, problem.detail].filter(Boolean).join(': '));
    this.status = problem.status;
    this.title = problem.title;
    this.detail = problem.detail ?? '';
    this.errors = problem.errors ?? [];
  }
}

/** Nobody answered. */
export class UnreachableError extends Error {
  override readonly name = 'UnreachableError';
}

/** The problem in a reply, whatever a proxy on the way may have made of it. */
export async function problemOf(reply: Response): Promise<ProblemError> {
  const text = await reply.text();
  const retry = Number(reply.headers.get('Retry-After') ?? NaN);
  return new ProblemError(parse(text, reply), Number.isFinite(retry) ? retry : undefined);
}

function parse(text: string, reply: Response): Problem {
  const fallback = { type: 'about:blank', title: reply.statusText || `Status ${reply.status}` };
  try {
    return { ...fallback, ...JSON.parse(text), status: reply.status };
  } catch {
    return { ...fallback, status: reply.status, detail: text.slice(0, 200) };
  }
}
