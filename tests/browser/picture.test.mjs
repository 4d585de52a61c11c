/** From a problem to its picture. */

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { atRest, drawn, eventually, heat, linkTo, looksLike, looksOther, pick, pixels, unitSquare, withPage } from './page.mjs';

const { interpolateViridis } = await import(
  pathToFileURL(join(process.env.SCATTERD_WEB, 'node_modules/d3-scale-chromatic/src/index.js')));

const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** Where a place of a box is on the canvas that has all of it in view. */
function pixelOf([x, y], lower, upper, { width, height }) {
  const margin = 36;
  const zoom = Math.min((width - 2 * margin) / (upper[0] - lower[0]), (height - 2 * margin) / (upper[1] - lower[1]));
  return [
    Math.round(width / 2 + zoom * (x - (lower[0] + upper[0]) / 2)),
    Math.round(height / 2 - zoom * (y - (lower[1] + upper[1]) / 2)),
  ];
}

function colourAt({ data, width }, [x, y]) {
  return data.slice(4 * (x + width * y), 4 * (x + width * y) + 3);
}

const distance = (a, b) => Math.max(...a.map((value, k) => Math.abs(value - b[k])));

test('Smith-Hutton: the colours are those of the solution', () => withPage(async ({ page, daemon }) => {
  await page.goto(daemon.url);
  const asked = page.waitForResponse(/execution/);
  await page.getByRole('link', { name: 'A front carried round a bend', exact: true }).click();
  const request = (await asked).request();
  await drawn(page, 81 * 41);
  const again = await fetch(request.url(), { method: 'POST', body: request.postDataBuffer(), headers: { 'Content-Type': 'application/cbor', Accept: 'application/json' } });
  const { solution, points } = await again.json();
  const inner = points.map((place, p) => ({ place, value: solution[p] }))
    .filter(({ place: [x, y] }, p) => p % 7 === 0 && Math.abs(x) < 0.95 && y > 0.05 && y < 0.95);
  const most = Math.max(...solution);
  await eventually(async () => {
    const image = await pixels(page);
    for (const { place, value } of inner) {
      const found = colourAt(image, pixelOf(place, [-1, 0], [1, 1], image));
      assert.ok(distance(found, rgb(interpolateViridis(value / most))) <= 6, `${place}: ${found} for ${value}`);
    }
    const colours = new Set(inner.map(({ place }) => colourAt(image, pixelOf(place, [-1, 0], [1, 1], image)).join()));
    assert.ok(colours.size > 40, `${colours.size} colours`);
  });
  assert.equal(await page.getByRole('img', { name: /Solution on/ }).count(), 1);
}));

test('a problem of the form: error, times, cut, neighbours, link', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', heat)}`);
  await page.getByRole('button', { name: 'Solve', exact: true }).click();
  await drawn(page, 441);
  const before = await atRest(page);
  await pick(page, 'Colour').selectOption('error');
  await page.getByRole('img', { name: /Error/ }).waitFor();
  await page.waitForFunction(() => document.querySelector('.stage-foot').textContent.includes('solved'));
  await looksOther(page, before);

  await page.getByLabel('Time', { exact: true }).focus();
  await page.keyboard.press('Home');
  await page.getByText('t = 0', { exact: true }).waitFor();
  await page.keyboard.press('End');

  await pick(page, 'Colour').selectOption('neighbours');
  await page.getByRole('img', { name: /Neighbours on 441 points/ }).waitFor();
  await page.getByRole('button', { name: 'Cut', exact: true }).click();
  await page.getByRole('tab', { name: 'Cut' }).click();
  await page.getByRole('img', { name: 'Neighbours along the cut' }).waitFor();
  await page.getByRole('tab', { name: 'History' }).click();
  await page.getByRole('img', { name: 'Error in time' }).waitFor();

  await page.getByRole('button', { name: 'Copy link' }).click();
  await page.getByRole('button', { name: 'Copied' }).waitFor();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  await page.goto('about:blank').catch(() => undefined);
  await page.goto(link);
  await page.getByRole('img', { name: /Neighbours on 441 points/ }).waitFor();
  assert.match(link, /field=neighbours/);
  assert.match(link, /cut=/);
}));

test('the keyboard moves, zooms and reads off', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', { ...heat, time: undefined, initial: undefined, exact: undefined, source: 1 }, { go: '1' })}`);
  await drawn(page, 441);
  const hands = page.locator('.hands');
  await hands.focus();
  const start = await atRest(page);
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('+');
  await looksOther(page, start);
  await atRest(page);
  await page.keyboard.press('0');
  await looksLike(page, start);
  await page.keyboard.press('Shift+ArrowRight');
  await page.locator('.probe b').waitFor();
  assert.match(await page.locator('.probe').innerText(), /at \(0\.5/);
}));

test('downloads: JSON, CBOR, CSV, VTP, PNG', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('solve', heat, { go: '1' })}`);
  await drawn(page, 441);
  await page.getByRole('tab', { name: 'Download' }).click();
  const get = async (name) => {
    const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name }).click()]);
    return readFile(await file.path());
  };
  assert.equal(JSON.parse(await get('JSON')).solution.length, 441);
  assert.ok((await get('CBOR')).length > 441 * 8);
  const lines = String(await get('CSV')).trim().split('\n');
  assert.deepEqual([lines.length, lines[0]], [442, 'x,y,solution,error']);
  assert.ok(lines[230].split(',').every((cell) => Number.isFinite(Number(cell))));
  const vtp = await get('VTP');
  assert.match(vtp.toString('latin1'), /NumberOfPoints="441".*/);
  const start = vtp.indexOf('encoding="raw">_') + 'encoding="raw">_'.length;
  assert.equal(vtp.readBigUInt64LE(start), BigInt(441 * 24));
  assert.equal((await get('PNG')).readUInt32BE(0), 0x89504e47);
}));

test('space and the line', () => withPage(async ({ page, daemon }) => {
  const box = { lattice: { lower: [0, 0, 0], upper: [1, 1, 1], cells: [8, 8, 8], jitter: 0.2, seed: 1 } };
  const boundary = [{ on: 'boundary', type: 'dirichlet', value: 0 }];
  await page.goto(`${daemon.url}/${linkTo('solve', { cloud: box, diffusivity: 1, source: 1, boundary }, { go: '1' })}`);
  await drawn(page, 729);
  const closed = await atRest(page);
  await pick(page, 'Open').fill('0.5');
  await looksOther(page, closed);
  const line = { lattice: { lower: [0], upper: [1], cells: [20] } };
  await page.goto(`${daemon.url}/${linkTo('solve', { cloud: line, diffusivity: 1, source: 1, boundary }, { go: '1' })}`);
  await page.getByRole('img', { name: 'Solution' }).waitFor();
}));

test('a study: table, convergence with its slope, and a look at a row', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/#run/study?study=gartland&go=1`);
  await page.getByRole('img', { name: 'Error over mesh size' }).waitFor();
  assert.equal(await page.locator('.plot-slope text').first().textContent(), '2');
  assert.ok((await page.locator('.numbers tbody tr').count()) >= 5);
  await page.getByRole('button', { name: 'look' }).first().click();
  await drawn(page, 61 * 61);
  assert.equal(await page.getByLabel('Cells', { exact: true }).inputValue(), '60, 60');
}));

test('what the cloud does: arrows of the artificial velocity', () => withPage(async ({ page, daemon }) => {
  await page.goto(`${daemon.url}/${linkTo('diagnose', { cloud: unitSquare(20, 0.6) }, { go: '1', field: 'artificial_velocity', arrows: 'artificial_velocity' })}`);
  await page.getByRole('img', { name: /Artificial velocity, size on 441/ }).waitFor();
  await pick(page, 'Colour').selectOption('effective_diffusivity');
  await page.getByRole('img', { name: /Effective diffusivity, mean on 441/ }).waitFor();
}));
