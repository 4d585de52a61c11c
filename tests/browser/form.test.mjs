/** The form: made from the descriptions, marked where the daemon objects, fed with files. */

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawn, eventually, linkTo, unitSquare, withPage } from './page.mjs';

const good = { cloud: unitSquare(10), diffusivity: 1, boundary: [{ on: 'boundary', type: 'dirichlet', value: 'x' }] };
const wrong = { ...good, velcity: 1, diffusivity: '1 + q', boundary: [{ on: 'botom', type: 'dirichlet', value: 0 }] };

test('problems mark the fields they point to', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', wrong)}`);
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await page.getByText('3 values are wrong', { exact: true }).waitFor();
  const field = page.getByLabel('Diffusivity', { exact: true });
  assert.equal(await field.getAttribute('aria-invalid'), 'true');
  const described = (await field.getAttribute('aria-describedby')).split(' ').at(-1);
  assert.match(await page.evaluate((id) => document.getElementById(id).textContent, described), /unknown name "q"/);
  await page.getByRole('button', { name: '/inputs/boundary/0/on' }).click();
  await eventually(async () => assert.equal(await page.evaluate(() => document.activeElement.value), 'botom'));

  await page.keyboard.press('ControlOrMeta+a');
  await page.keyboard.type('boundary');
  await field.fill('1 + x');
  await page.getByRole('tab', { name: 'JSON' }).click();
  const text = JSON.parse(await page.getByLabel('Inputs, or a whole request').inputValue());
  delete text.velcity;
  await page.getByLabel('Inputs, or a whole request').fill(JSON.stringify({ inputs: text }));
  await page.keyboard.press('ControlOrMeta+Enter');
  await drawn(page, 121);
}, { refusals: true }));

test('members come and go', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', good)}`);
  await page.getByRole('button', { name: '+ Operator' }).click();
  await page.getByRole('button', { name: '+ Scheme' }).click();
  await page.getByLabel('Scheme', { exact: true }).selectOption('ips');
  await page.getByRole('button', { name: '+ Source' }).click();
  await page.getByLabel('Source', { exact: true }).fill('sin(x)');
  await page.getByRole('button', { name: 'Add', exact: true }).last().click();
  await page.getByRole('tab', { name: 'Code' }).click();
  const snippets = await page.locator('.snippet pre').allInnerTexts();
  assert.match(snippets[0], /^curl .*"source": "sin\(x\)"/s);
  assert.match(snippets[1], /client\.solve\(.*operator=\{"scheme": "ips"\}/s);
}));

test('a cloud is dropped as CSV, with its groups', () => withPage(async ({ page, daemon }) => {
  const rows = ['x,y,group'];
  for (let j = 0; j <= 10; j++) {
    for (let i = 0; i <= 10; i++) rows.push(`${i / 10},${j / 10},${i % 10 === 0 || j % 10 === 0 ? 'rim' : ''}`);
  }
  await page.goto(`${daemon.url}/${linkTo('solve', { ...good, boundary: [{ on: 'rim', type: 'dirichlet', value: 'x' }] })}`);
  await page.getByRole('radio', { name: 'Own points' }).click();
  const data = await page.evaluateHandle((text) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([text], 'points.csv'));
    return transfer;
  }, rows.join('\n'));
  await page.dispatchEvent('.drop', 'drop', { dataTransfer: data });
  await page.getByText('121 × 2 coordinates; groups rim (40)').waitFor();
  await drawn(page, 121); // before anything is solved
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await page.getByRole('img', { name: /Solution on 121 points, from 0 to 1/ }).waitFor();
}));

/** A file of numpy, version 1.0. */
function npy(rows, columns, numbers) {
  const head = `{'descr': '<f8', 'fortran_order': False, 'shape': (${rows}, ${columns}), }`;
  const header = head.padEnd(Math.ceil((10 + head.length + 1) / 64) * 64 - 11) + '\n';
  const bytes = Buffer.alloc(10 + header.length + 8 * numbers.length);
  bytes.write('\x93NUMPY\x01\x00', 'latin1');
  bytes.writeUInt16LE(header.length, 8);
  bytes.write(header, 10, 'latin1');
  numbers.forEach((value, k) => bytes.writeDoubleLE(value, 10 + header.length + 8 * k));
  return bytes;
}

test('a cloud is chosen as .npy or pasted as JSON; what is no cloud is said so', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('diagnose', { cloud: { points: [] } })}`);
  const points = Array.from({ length: 36 }, (_, k) => [(k % 6) / 5, Math.floor(k / 6) / 5]);
  await page.setInputFiles('input[type=file]', { name: 'cloud.npy', mimeType: '', buffer: npy(36, 2, points.flat()) });
  await page.getByText('36 × 2 coordinates; no groups').waitFor();
  await page.setInputFiles('input[type=file]', { name: 'cloud.npy', mimeType: '', buffer: Buffer.from('not numpy at all') });
  await page.getByText('it is not an .npy file').waitFor();
  await page.getByRole('button', { name: 'Paste JSON' }).click();
  await page.getByLabel('Points as JSON').fill(JSON.stringify(points.slice(0, 30)));
  await page.getByLabel('Points as JSON').blur();
  await page.getByText('30 × 2 coordinates').waitFor();
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await page.getByRole('img', { name: /Neighbours on 30 points/ }).waitFor();
}));

test('every process has a form', () => withPage(async ({ page, daemon }) => {
  const { processes } = await (await fetch(`${daemon.url}/processes`)).json();
  for (const { id } of processes) {
    await page.goto(`${daemon.url}/#run/${id}`);
    await page.waitForFunction((name) => document.querySelector('.problem select').value === name && document.querySelector('.form :is(.field, .group, .chips)'), id);
  }
}));
