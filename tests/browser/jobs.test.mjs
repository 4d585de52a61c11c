/** Jobs: followed, cancelled, listed. */

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawn, heat, linkTo, long, pick, withPage } from './page.mjs';

async function submit(page, url, inputs) {
  await page.goto(`${url}/${linkTo('solve', inputs)}`);
  await page.getByLabel('as a job').check();
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
}

test('a job is followed to its result, which a link brings back', () => withPage(async ({ page, daemon }) => {
  await submit(page, daemon.url, { ...heat, time: { ...heat.time, step: 2e-5 } });
  await drawn(page, 441);
  await page.getByRole('link', { name: 'Jobs', exact: true }).click();
  await page.locator('.status-successful').waitFor();
  await page.locator('.job-list a').first().click();
  await page.getByRole('img', { name: /Solution on 441 points/ }).waitFor();
  await pick(page, 'Colour').selectOption('error'); // the request is remembered
  await page.getByRole('img', { name: /Error/ }).waitFor();
}));

test('progress is shown, and a long job cancelled', () => withPage(async ({ page, daemon }) => {
  await submit(page, daemon.url, long);
  await page.getByText('The job is running').waitFor();
  await page.waitForFunction(() => document.querySelector('progress')?.value > 0);
  const seen = await page.locator('progress').evaluate((bar) => bar.value);
  await page.waitForFunction((before) => document.querySelector('progress')?.value > before, seen);
  const { jobs } = await (await fetch(`${daemon.url}/jobs`)).json();
  assert.equal(jobs[0].status, 'running');
  await page.getByRole('button', { name: 'Cancel' }).first().click();
  await page.getByRole('button', { name: 'Solve', exact: true }).waitFor();
  await page.getByRole('link', { name: 'Jobs', exact: true }).click();
  await page.locator('.status-dismissed').waitFor();
}));

test('the list filters, and cancels', () => withPage(async ({ page, daemon }) => {
  const post = (process, inputs) => fetch(`${daemon.url}/processes/${process}/execution`, {
    method: 'POST', headers: { 'Content-Type': 'application/json', Prefer: 'respond-async' }, body: JSON.stringify({ inputs }),
  });
  await post('echo', { message: 'one' });
  await post('solve', long);
  await page.goto(`${daemon.url}/#jobs`);
  await page.waitForFunction(() => document.querySelectorAll('.job-list tbody tr').length === 2);
  await pick(page, 'Process').selectOption('solve');
  await page.waitForFunction(() => document.querySelectorAll('.job-list tbody tr').length === 1);
  await pick(page, 'Status').selectOption('running');
  await page.locator('.status-running').waitFor();
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.getByText('None fits the filter.').waitFor();
  await pick(page, 'Status').selectOption('dismissed');
  await page.locator('.status-dismissed').waitFor();
}));

test('a solve that one waits for is cancelled too', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', long, { go: '1' })}`);
  await page.getByText('Solving').waitFor();
  await page.getByRole('button', { name: 'Cancel' }).first().click();
  await page.getByText('press Solve').waitFor();
}, { away: true }));

test('a failed job says why', () => withPage(async ({ page, daemon }) => {
  const singular = { cloud: { points: [[0, 0], [1, 0], [2, 0], [3, 0], [9, 9]] }, diffusivity: 1, boundary: [{ on: [0], type: 'dirichlet', value: 0 }] };
  await submit(page, daemon.url, singular);
  await page.locator('.failure').waitFor();
  assert.match(await page.locator('.outcome').innerText(), /\w+ \w+/);
}, { refusals: true }));
