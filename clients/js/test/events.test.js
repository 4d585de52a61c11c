/** Jobs against a server made for the purpose, which breaks connections where it hurts. */

import assert from 'node:assert/strict';
import { once } from 'node:events';
import { createServer } from 'node:http';
import { test } from 'node:test';
import { library } from './library.js';

const { Client, UnreachableError } = library;

async function serving(handle, act) {
  const server = createServer(handle).listen(0, '127.0.0.1');
  await once(server, 'listening');
  try {
    return await act(new Client(`http://127.0.0.1:${server.address().port}`));
  } finally {
    server.closeAllConnections();
    server.close();
  }
}

const stream = { 'Content-Type': 'text/event-stream' };
const running = JSON.stringify({ jobID: 'a', status: 'running' });

function answerJson(reply, text, status = 200) {
  reply.writeHead(status, { 'Content-Type': 'application/json' }).end(text);
}

test('events go on where the broken connection ended', async () => {
  const seen = [];
  const handle = (request, reply) => {
    if (!request.url.endsWith('/events')) return answerJson(reply, running);
    seen.push(request.headers['last-event-id']);
    reply.writeHead(200, stream);
    if (seen.length === 1) {
      reply.write('retry: 10\n\n: hello\n\nid: 1\nevent: progress\ndata: {"progress":10}\n\n');
      reply.end('id: 2\nevent: progress\r\ndata: {"progress"\ndata: :20}\r\n\r\nid: 3\ndata: lost');
    } else {
      reply.end('id: 3\nevent: status\ndata: {"status":"successful"}\n\n');
    }
  };
  const events = await serving(handle, async (client) => {
    const found = [];
    for await (const event of client.job('a').events()) found.push(event);
    return found;
  });
  assert.deepEqual(seen, [undefined, '2']);
  assert.deepEqual(events.map(({ type, data }) => [type, data]), [
    ['progress', { progress: 10 }],
    ['progress', { progress: 20 }],
    ['status', { status: 'successful' }],
  ]);
});

test('without an end in the events, the status decides', async () => {
  const handle = (request, reply) => {
    if (request.url.endsWith('/events')) return reply.writeHead(200, stream).end();
    answerJson(reply, JSON.stringify({ jobID: 'a', status: 'failed' }));
  };
  const events = await serving(handle, async (client) => {
    const found = [];
    for await (const event of client.job('a').events()) found.push(event);
    return found;
  });
  assert.deepEqual(events.map(({ data }) => data.status), ['failed']);
});

test('a restart in between is waited out, too many streams as well', async () => {
  let calls = 0;
  const handle = (request, reply) => {
    calls++;
    if (calls < 3) return request.socket.destroy();
    if (calls === 3) return answerJson(reply, '{"title":"starting","status":503}', 503);
    if (calls === 4) return answerJson(reply, '{"title":"too many","status":429}', 429);
    if (!request.url.endsWith('/events')) return answerJson(reply, running);
    reply.writeHead(200, stream).end('event: status\ndata: {"status":"successful"}\n\n');
  };
  await serving(handle, async (client) => {
    const fast = client.job('a').events();
    const { value } = await fast.next();
    assert.equal(value.data.status, 'successful');
  });
});

test('an unknown job ends it, an abort too', async () => {
  const unknown = (_request, reply) => answerJson(reply, '{"title":"no such job","status":404}', 404);
  await serving(unknown, (client) =>
    assert.rejects(client.job('a').events().next(), { status: 404 }));
  const silent = (_request, reply) => reply.writeHead(200, stream).write(': \n\n');
  await serving(silent, (client) =>
    assert.rejects(client.job('a').events({ signal: AbortSignal.timeout(50) }).next(), { name: 'TimeoutError' }));
  await assert.rejects(new Client('http://127.0.0.1:1').jobs(), UnreachableError);
});
