/** A text/event-stream, read from a fetch body (WHATWG HTML, section 9.2). EventSource itself is
 *  missing in Node 18 and cannot send headers. */

export interface ServerEvent {
  type: string;
  data: string;
  id: string;
}

/** What a stream has told so far; survives the connection, so that the next can go on. */
export interface StreamState {
  lastId: string;
  /** Milliseconds to wait before connecting again. */
  retry: number;
}

export async function* readEvents(
  body: ReadableStream<Uint8Array>,
  state: StreamState,
  signal?: AbortSignal,
): AsyncGenerator<ServerEvent> {
  const block = new Block(state);
  for await (const line of linesOf(body, signal)) {
    const event = block.take(line);
    if (event) yield event;
  }
}

/** The fields of one event until the empty line that ends it. */
class Block {
  private data: string[] = [];
  private type = '';
  private id: string;

  constructor(private readonly state: StreamState) {
    this.id = state.lastId;
  }

  take(line: string): ServerEvent | undefined {
    if (line === '') return this.finish();
    const colon = line.indexOf(':');
    if (colon === 0) return undefined; // a comment, which keeps the connection alive
    const name = colon < 0 ? line : line.slice(0, colon);
    this.setField(name, colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, ''));
    return undefined;
  }

  private setField(name: string, value: string): void {
    if (name === 'data') this.data.push(value);
    if (name === 'event') this.type = value;
    if (name === 'id' && !value.includes('\0')) this.id = value;
    if (name === 'retry' && /^[0-9]+$/.test(value)) this.state.retry = Number(value);
  }

  private finish(): ServerEvent | undefined {
    const { data, type } = this;
    this.state.lastId = this.id; // not before: an event cut off has not been seen
    this.data = [];
    this.type = '';
    if (data.length === 0) return undefined;
    return { type: type || 'message', data: data.join('\n'), id: this.state.lastId };
  }
}

/** Never settles but by the signal. fetch of Node 18 may forget the signal while a body is read. */
function abortion(signal: AbortSignal): Promise<never> {
  const promise = new Promise<never>((_, reject) => {
    if (signal.aborted) reject(signal.reason);
    signal.addEventListener('abort', () => reject(signal.reason), { once: true });
  });
  promise.catch(() => undefined); // it may come when nobody reads any more
  return promise;
}

async function* linesOf(body: ReadableStream<Uint8Array>, signal?: AbortSignal): AsyncGenerator<string> {
  const reader = body.getReader();
  const aborted = signal && abortion(signal);
  const decoder = new TextDecoder();
  let rest = '';
  try {
    for (;;) {
      const { done, value } = await (aborted ? Promise.race([reader.read(), aborted]) : reader.read());
      if (done) return;
      rest += decoder.decode(value, { stream: true });
      const lines = rest.split(/\r\n|\n|\r(?!$)/);
      rest = lines.pop() ?? '';
      yield* lines;
    }
  } finally {
    void reader.cancel().catch(() => undefined); // not awaited: after an abort it may never settle
  }
}
