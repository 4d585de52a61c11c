import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { promisify } from 'node:util';
import { startDaemon } from './daemon.js';
import { library } from './library.js';

const { Client, lattice, latticePoints, NdArray, ProblemError, UnreachableError } = library;

let daemon;
before(async () => {
  daemon = await startDaemon();
});
after(() => daemon.stop());

const exact = 'sin(3*x + 1) * cos(2*y)';
const laplace = {
  cloud: lattice([0, 0], [1, 1], [24, 24], { jitter: 0.3, seed: 5 }),
  diffusivity: 1,
  source: `13 * ${exact}`,
  boundary: [{ on: 'boundary', type: 'dirichlet', value: exact }],
  exact,
};

test('a daemon that wants tokens gets one', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'scatterd-token-'));
  const file = join(folder, 'tokens');
  const made = await promisify(execFile)(process.env.SCATTERD, ['token', 'me']);
  await writeFile(file, made.stdout, { mode: 0o600 });
  const guarded = await startDaemon({ options: ['--tokens', file] });
  try {
    const client = new Client(guarded.url, { token: made.stderr.trim().split(' ').pop() });
    const job = await client.submit('echo', { message: 'known' });
    assert.equal((await job.wait()).message, 'known');
    const stranger = new Client(guarded.url);
    await assert.rejects(stranger.jobs(), (error) => error instanceof ProblemError && error.status === 401);
    await assert.rejects(stranger.job(job.id).wait(), (error) => error.status === 401);
  } finally {
    await guarded.stop();
    await rm(folder, { recursive: true });
  }
});

test('processes are listed and described', async () => {
  const client = new Client(daemon.url);
  const ids = (await client.processes()).map(({ id }) => id);
  assert.ok(ids.includes('solve') && ids.includes('study'));
  const solve = await client.process('solve');
  assert.equal(solve.inputs.cloud.minOccurs, 1);
  assert.equal(solve.inputs.operator.schema.properties.scheme.default, 'lsmps');
});

for (const format of ['cbor', 'json']) {
  test(`solve answers in ${format}`, async () => {
    const result = await new Client(daemon.url, { format }).solve(laplace);
    assert.equal(result.solution.length, 625);
    assert.equal(result.points.length, 625);
    assert.ok(result.norms.l2 > 0 && result.norms.l2 < 1e-3);
    assert.equal(result.solution instanceof Float64Array, format === 'cbor');
    assert.equal(result.points instanceof NdArray, format === 'cbor');
  });
}

test('both formats carry the same bits', async () => {
  const [cbor, json] = await Promise.all(
    ['cbor', 'json'].map((format) =>
      new Client(daemon.url, { format }).solve(laplace, { outputs: ['solution', 'points'] })),
  );
  assert.deepEqual(Array.from(cbor.solution), json.solution);
  assert.deepEqual(cbor.points.toJSON(), json.points);
  assert.deepEqual(Object.keys(cbor).sort(), ['points', 'solution']);
});

test('latticePoints makes the points of the daemon, bit for bit', async () => {
  for (const [lower, upper, cells] of [
    [[0], [2], [9]],
    [[-1, 0.5], [1, 2], [7, 5]],
    [[0, 0, 0], [1, 2, 3], [3, 4, 5]],
  ]) {
    const cloud = lattice(lower, upper, cells, { jitter: 0.7, seed: 123 });
    const inputs = { cloud, diffusivity: 1, boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }] };
    const { points } = await new Client(daemon.url).solve(inputs, { outputs: ['points'] });
    assert.deepEqual(Array.from(latticePoints(cloud.lattice).data), Array.from(points.data ?? points));
  }
});

test('typed arrays go in, in both formats', async () => {
  const points = latticePoints(lattice([0, 0], [1, 1], [6, 6]).lattice);
  const rim = Int32Array.from(
    Array.from({ length: 49 }, (_, k) => k).filter((k) => points.row(k).some((c) => c === 0 || c === 1)));
  for (const format of ['cbor', 'json']) {
    const result = await new Client(daemon.url, { format }).solve({
      cloud: { points, groups: { rim } },
      diffusivity: new Float64Array(49).fill(1),
      boundary: [{ on: 'rim', type: 'dirichlet', value: 'x' }],
    });
    for (let k = 0; k < 49; k++) {
      assert.ok(Math.abs(result.solution[k] - points.row(k)[0]) < 1e-12);
    }
  }
});

test('a refusal names every culprit', async () => {
  const bad = { ...laplace, velcity: 1, diffusivity: -1 };
  await assert.rejects(new Client(daemon.url).execute('solve', bad), (error) => {
    assert.ok(error instanceof ProblemError);
    assert.equal(error.status, 400);
    assert.ok(error.errors.some(({ pointer }) => pointer === '/inputs/velcity'));
    return true;
  });
  await assert.rejects(new Client(daemon.url).process('nothing'), { status: 404 });
});

test('nobody there is an UnreachableError, an abort is an abort', async () => {
  await assert.rejects(new Client('http://127.0.0.1:1').processes(), UnreachableError);
  const client = new Client(daemon.url);
  const stop = AbortSignal.timeout(100);
  await assert.rejects(
    client.execute('echo', { message: 'slow', pause: 30 }, { signal: stop }),
    { name: 'TimeoutError' });
  assert.equal((await client.execute('echo', { message: 'next' })).message, 'next');
});

test('shapes are checked', () => {
  assert.throws(() => new NdArray(new Float64Array(5), [2, 3]), RangeError);
  assert.throws(() => NdArray.from([[1, 2], [3]]), /row 1 has 1 numbers/);
  assert.deepEqual(NdArray.from([[1, 2], [3, 4]]).column(1), Float64Array.of(2, 4));
});

test('a web page of another origin may read what it needs', async () => {
  const other = await startDaemon({ options: ['--cors-origins', 'https://a.example'] });
  try {
    const headers = { Origin: 'https://a.example' };
    const { headers: listed } = await fetch(`${other.url}/processes`, { headers });
    assert.equal(listed.get('Access-Control-Allow-Origin'), 'https://a.example');
    assert.match(listed.get('Access-Control-Expose-Headers'), /Location.*Retry-After/);
    const preflight = await fetch(`${other.url}/processes/solve/execution`, { method: 'OPTIONS', headers });
    assert.match(preflight.headers.get('Access-Control-Allow-Methods'), /POST/);
    for (const name of ['Accept', 'Content-Type', 'Prefer', 'Last-Event-ID', 'Authorization']) {
      assert.ok(preflight.headers.get('Access-Control-Allow-Headers').includes(name), name);
    }
  } finally {
    await other.stop();
  }
});
