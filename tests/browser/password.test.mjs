/** A daemon that wants tokens: the browser asks for name and secret, and the page works as ever. */

import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { drawn, heat, linkTo, withPage } from './page.mjs';

/** Acts on a page of a daemon with a token called me; `known`: the browser is told its secret. */
async function guarded(act, known) {
  const folder = await mkdtemp(join(tmpdir(), 'scatterd-browser-'));
  const file = join(folder, 'tokens');
  const made = await promisify(execFile)(process.env.SCATTERD, ['token', 'me']);
  await writeFile(file, made.stdout, { mode: 0o600 });
  const httpCredentials = { username: 'me', password: made.stderr.trim().split(' ').pop() };
  try {
    await withPage(act, {
      daemon: { options: ['--tokens', file] }, refusals: true, ...(known && { httpCredentials }),
    });
  } finally {
    await rm(folder, { recursive: true });
  }
}

test('with name and secret all works, a job and its events too', () => guarded(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', { ...heat, time: { ...heat.time, step: 2e-5 } })}`);
  await page.getByLabel('as a job').check();
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await drawn(page, 441);
  await page.getByRole('link', { name: 'Jobs', exact: true }).click();
  await page.locator('.status-successful').waitFor();
}, true));

test('without them there is no page', () => guarded(async ({ page, daemon }) => {
  const reply = await page.goto(daemon.url).catch((error) => error);
  assert.ok(reply instanceof Error || reply.status() === 401, String(reply));
  assert.equal(await page.locator('main').count(), 0);
}, false));
