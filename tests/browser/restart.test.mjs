/** The page outlives the daemon. */

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { startDaemon } from '../../clients/js/test/daemon.js';
import { drawn, heat, linkTo, withPage } from './page.mjs';

test('the daemon goes and comes back: nothing typed is lost, and the page goes on', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', heat)}`);
  await page.getByLabel('Diffusivity', { exact: true }).fill('2');
  await daemon.stop({ keep: true });
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await page.getByText('The daemon does not answer.').waitFor();
  const again = await startDaemon({ port: daemon.port, directory: daemon.data });
  try {
    await page.getByText('The daemon does not answer.').waitFor({ state: 'detached' });
    assert.equal(await page.getByLabel('Diffusivity', { exact: true }).inputValue(), '2');
    await page.getByRole('button', { name: 'Solve', exact: true }).click();
    await drawn(page, 441);
  } finally {
    await again.stop({ keep: true });
  }
}, { away: true }));

test('a job that was running is followed across a restart', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', { ...heat, time: { ...heat.time, step: 2e-6 } })}`);
  await page.getByLabel('as a job').check();
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await page.waitForFunction(() => document.querySelector('progress')?.value > 0);
  await daemon.stop({ keep: true, signal: 'SIGKILL' });
  await page.waitForTimeout(500);
  const again = await startDaemon({ port: daemon.port, directory: daemon.data });
  try {
    await drawn(page, 441);
  } finally {
    await again.stop({ keep: true });
  }
}, { away: true }));
