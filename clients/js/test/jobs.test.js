/** Jobs of a real daemon. */

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { startDaemon } from './daemon.js';
import { library } from './library.js';

const { Client } = library;

let daemon;
let client;
before(async () => {
  daemon = await startDaemon();
  client = new Client(daemon.url);
});
after(() => daemon.stop());

const heat = {
  cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [20, 20], jitter: 0.2, seed: 1 } },
  diffusivity: 1,
  initial: 'sin(pi*x) * sin(pi*y)',
  time: { method: 'backward-euler', end: 0.1, step: 5e-5 },
  boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }],
};

test('a job is submitted, followed, and its result fetched', async () => {
  const job = await client.submit('solve', heat, { outputs: ['solution'] });
  const events = [];
  const result = await job.wait({ onEvent: (event) => events.push(event) });
  assert.deepEqual(Object.keys(result), ['solution']);
  assert.ok(result.solution instanceof Float64Array && result.solution.length === 441);
  assert.equal(events.at(-1).data.status, 'successful');
  assert.equal((await job.status()).progress, 100);
  const later = [];
  for await (const event of job.events()) later.push(event);
  assert.equal(later.at(-1).data.status, 'successful');
});

test('a job is dismissed while it runs', async () => {
  const job = await client.submit('solve', { ...heat, time: { ...heat.time, end: 1, step: 1e-6 } });
  for await (const { data } of job.events()) if (data.status === 'running' || data.progress > 0) break;
  assert.equal((await job.dismiss()).status, 'dismissed');
  await assert.rejects(job.results(), { status: 410 });
  await assert.rejects(job.wait(), { status: 410 });
});

test('jobs are listed by status and process, page by page', async () => {
  const job = await client.submit('echo', { message: 'hello' });
  await job.wait();
  const { jobs } = await client.jobs({ processID: 'echo', status: ['successful'] });
  assert.deepEqual(jobs.map(({ jobID }) => jobID), [job.id]);
  const page = await client.jobs({ limit: 1 });
  assert.equal(page.jobs.length, 1);
  assert.ok(page.more);
  await assert.rejects(client.job('nothing').status(), { status: 404 });
});

test('a bad request is refused before it becomes a job', async () => {
  await assert.rejects(client.submit('solve', { ...heat, diffusivity: -1 }), { status: 400 });
});

test('an aborted wait leaves the job alone', async () => {
  const job = await client.submit('echo', { message: 'slow', pause: 1 });
  await assert.rejects(job.wait({ signal: AbortSignal.timeout(50) }));
  assert.equal((await job.wait()).message, 'slow');
});
