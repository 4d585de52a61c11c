/** Batches: composed, pasted, made of a table, objected to, followed to the result of every request. */

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawn, heat, linkTo, long, pick, unitSquare, withPage } from './page.mjs';

const wall = [{ on: 'boundary', type: 'dirichlet', value: 0 }];
const solve = (inputs) => ({ process: 'solve', inputs: { boundary: wall, ...inputs } });
const batch = { cloud: unitSquare(10), requests: [solve({ diffusivity: 1, source: 'x' }), { process: 'diagnose', inputs: {} }] };

const submit = (page) => page.getByRole('button', { name: 'Submit', exact: true }).click();
const rows = (page) => page.locator('.parts tbody tr');
const jsonOf = async (page) => {
  await page.getByRole('tab', { name: 'JSON' }).click();
  const text = await page.getByLabel('Inputs, or a whole request').inputValue();
  await page.getByRole('tab', { name: 'Form' }).click();
  return JSON.parse(text);
};

test('requests are added, copied, changed and removed', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('batch', batch)}`);
  await page.getByText('2 requests', { exact: true }).waitFor();
  assert.equal(await page.getByLabel('as a job').count(), 0); // it always is
  await page.getByRole('button', { name: 'Add a request' }).click();
  const third = page.locator('.entry').nth(2);
  await third.getByLabel('Process', { exact: true }).selectOption('echo');
  await third.getByLabel('Message', { exact: true }).fill('third');
  await page.getByRole('button', { name: 'Copy request 1' }).click();
  await page.getByRole('button', { name: 'Remove request 2' }).click();
  assert.equal(await third.locator('b').innerText(), '3. solve');
  await page.locator('.entry').nth(1).getByLabel('Message', { exact: true }).waitFor(); // still open
  const { requests } = await jsonOf(page);
  assert.deepEqual(requests, [batch.requests[0], { process: 'echo', inputs: { message: 'third' } }, batch.requests[0]]);
}));

test('requests are pasted and read from files; what is none is said so', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('batch', { requests: [] })}`);
  const field = page.getByLabel('Or paste requests as JSON');
  const add = page.getByRole('button', { name: 'Add these' });
  const echo = (message) => ({ process: 'echo', inputs: { message } });
  await field.fill(JSON.stringify([echo('a'), echo('b')]));
  await add.click();
  await page.getByText('2 requests added.').waitFor();
  await field.fill(`${JSON.stringify(echo('c'))}\n\n${JSON.stringify(echo('d'))}\n`);
  await add.click();
  await field.fill(JSON.stringify({ inputs: { requests: [echo('e')] } }));
  await add.click();
  for (const [text, trouble] of [['{"process": "echo"}', /Nothing was added: number 1 is no request/], ['[{', /Nothing was added: .*JSON/]]) {
    await field.fill(text);
    await add.click();
    await page.getByText(trouble).waitFor();
    assert.equal(await field.inputValue(), text);
  }
  await page.setInputFiles('.paste input[type=file]', ['f', 'g'].map((name) => ({ name: `${name}.json`, mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(echo(name))) })));
  await page.getByText('7 requests', { exact: true }).waitFor();
  const { requests } = await jsonOf(page);
  assert.equal(requests.map(({ inputs }) => inputs.message).join(''), 'abcdefg');
}));

test('what is wrong with a request is marked in it', () => withPage(async ({ page, daemon }) => {
  const requests = [...batch.requests, solve({ difusivity: 1, diffusivity: '1 + q' })];
  await page.goto(`${daemon.url}/${linkTo('batch', { ...batch, requests })}`);
  await page.getByText('3 requests', { exact: true }).waitFor();
  await submit(page);
  await page.getByText('2 values wrong', { exact: true }).waitFor(); // opens the request
  await page.getByRole('button', { name: '/inputs/requests/2/inputs/diffusivity' }).click();
  assert.equal(await page.evaluate(() => document.activeElement.value), '1 + q');
  assert.equal(await page.getByLabel('Diffusivity', { exact: true }).getAttribute('aria-invalid'), 'true');
  assert.equal(await page.locator('.entry.part.wrong').count(), 1);
  await page.getByRole('button', { name: 'Remove difusivity' }).click();
  await page.getByLabel('Diffusivity', { exact: true }).fill('1 + x');
  await submit(page);
  await page.getByText('3 requests successful').waitFor();
}, { refusals: true }));

test('every request is listed with its state, and leads to its result', () => withPage(async ({ page, daemon }) => {
  const requests = [solve({ diffusivity: 1, source: 1, exact: 'x' }), solve({ diffusivity: 0 }), { process: 'diagnose', inputs: {} }];
  await page.goto(`${daemon.url}/${linkTo('batch', { ...batch, requests })}`);
  await submit(page);
  await page.getByText('2 requests successful, 1 not').waitFor();
  assert.deepEqual(await rows(page).locator('.status').allInnerTexts(), ['successful', 'failed', 'successful']);
  assert.deepEqual(await rows(page).locator('a').allInnerTexts(), ['solve', 'solve', 'diagnose']);
  assert.match(await rows(page).nth(1).innerText(), /singular system.*diffusivity 0/s);
  const download = page.waitForEvent('download');
  await page.getByRole('link', { name: 'Download all results' }).click();
  assert.match((await download).suggestedFilename(), /^batch-.*\.json$/);
  await page.getByRole('link', { name: 'Request 1, solve' }).click();
  await drawn(page, 121);
  await pick(page, 'Colour').selectOption('error'); // what the request was is known
  await page.getByRole('img', { name: /Error/ }).waitFor();
  await page.getByRole('link', { name: 'Jobs', exact: true }).click();
  await page.locator('.job-list a').first().click(); // the batch, once more
  await page.getByRole('link', { name: 'Request 3, diagnose' }).waitFor();
}));

test('a batch under way can be watched and cancelled', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('batch', { requests: [{ process: 'solve', inputs: heat }, { process: 'solve', inputs: long }] })}`);
  await submit(page);
  await rows(page).locator('.status-running').waitFor();
  await page.waitForFunction(() => document.querySelector('.parts progress')?.value > 0);
  await rows(page).first().locator('.status-successful').waitFor();
  await page.getByRole('button', { name: 'Cancel all' }).click();
  await page.getByRole('button', { name: 'Submit', exact: true }).waitFor();
  await page.getByRole('link', { name: 'Jobs', exact: true }).click();
  await page.locator('.status-dismissed').waitFor();
}));

test('a table of parameters makes a request of every row', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('batch', { cloud: batch.cloud, requests: [solve({ diffusivity: 'd', source: 's' })] })}`);
  await page.getByRole('radio', { name: 'Table of parameters' }).click();
  const add = page.getByRole('button', { name: 'Add a parameter' });
  for (const [k, [name, values]] of [['d', '1, 2 4'], ['s', '1\t2']].entries()) {
    await add.click();
    const names = page.getByLabel('Name of the parameter').nth(k);
    await names.fill(name);
    await names.blur();
    await page.getByLabel(`Values of ${name}`).fill(values);
  }
  await page.getByText('The columns are not of the same length').waitFor();
  await page.getByLabel('Values of s').fill('1, 2, 3');
  await page.getByText('makes 3 requests').waitFor();
  await submit(page);
  await page.getByText('3 requests successful').waitFor();
  assert.match(await rows(page).nth(2).innerText(), /d 4, s 3/);
}));

test('a job that another browser asked for shows what is known of it', () => withPage(async ({ page, daemon }) => {
  const headers = { 'Content-Type': 'application/json', Prefer: 'respond-async' };
  const post = async (process, inputs) => (await (await fetch(`${daemon.url}/processes/${process}/execution`, { method: 'POST', headers, body: JSON.stringify({ inputs }) })).json()).jobID;
  await page.goto(`${daemon.url}/#jobs/${await post('solve', { ...solve({ diffusivity: 1 }).inputs, cloud: unitSquare(10) })}`);
  await drawn(page, 121);
  await page.getByText('What was asked is not known here').waitFor();
  await page.goto(`${daemon.url}/#jobs/${await post('batch', batch)}`);
  await page.getByText('2 requests successful').waitFor();
  assert.equal(await rows(page).count(), 2);
}));
