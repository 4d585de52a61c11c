/** Keyboard, screen reader, light, dark, narrow: by the rules of axe, and by use. */

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { drawn, eventually, heat, linkTo, need, withPage } from './page.mjs';

const axe = readFileSync(need.resolve('axe-core/axe.min.js'), 'utf8');

async function violations(page) {
  await page.evaluate(axe);
  const { violations: found } = await page.evaluate(() => window.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'] }));
  return found.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map(({ html }) => html.slice(0, 160)).join(' | ')}`);
}

const views = {
  catalogue: ['', (page) => page.getByRole('heading', { name: 'A boundary layer', exact: true }).waitFor()],
  problem: [linkTo('solve', heat, { go: '1' }), (page) => drawn(page, 441)],
  study: ['#run/study?study=gartland&go=1', (page) => page.getByRole('img', { name: 'Error over mesh size' }).waitFor()],
  batch: [linkTo('batch', { cloud: heat.cloud, requests: [{ inputs: { diffusivity: 1 } }, { process: 'diagnose', inputs: {} }] }), async (page) => {
    await page.getByRole('button', { name: '1. solve' }).click();
    await page.getByLabel('Diffusivity', { exact: true }).waitFor();
    await page.getByRole('button', { name: 'Submit', exact: true }).click();
    await page.getByRole('link', { name: 'Download all results' }).waitFor();
  }],
  jobs: ['#jobs', (page) => page.locator('.job-list td').first().waitFor()], // that of the batch
};

for (const colorScheme of ['light', 'dark']) {
  test(`axe finds nothing, ${colorScheme}`, () => withPage(async ({ page, daemon }) => {
    for (const [name, [path, ready]] of Object.entries(views)) {
      await page.goto(`${daemon.url}/${path}`);
      await ready(page);
      assert.deepEqual(await violations(page), [], name);
    }
  }, { colorScheme }));
}

test('a narrow screen needs no scrolling to the side', () => withPage(async ({ page, daemon }) => {
  for (const [name, [path, ready]] of Object.entries(views)) {
    await page.goto(`${daemon.url}/${path}`);
    await ready(page);
    const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(over <= 0, `${name} is ${over} px too wide`);
  }
}, { viewport: { width: 390, height: 844 } }));

test('a problem is posed and solved without a mouse', () => withPage(async ({ page, daemon }) => {
  await page.goto(daemon.url);
  await page.getByRole('heading', { name: 'A boundary layer', exact: true }).waitFor();
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter'); // skip to the content
  await eventually(async () =>
    assert.equal(await page.evaluate(() => document.activeElement.textContent), 'A front carried round a bend'));
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter'); // edit it
  await page.getByLabel('Diffusivity', { exact: true }).focus();
  await page.keyboard.press('Control+Enter');
  await drawn(page, 81 * 41);
  await page.getByRole('tab', { name: 'Numbers' }).focus();
  await page.keyboard.press('ArrowRight');
  await eventually(async () =>
    assert.equal(await page.getByRole('tab', { name: 'Cut' }).getAttribute('aria-selected'), 'true'));
}));

test('the theme can be chosen, and stays', () => withPage(async ({ page, daemon }) => {
  await page.goto(daemon.url);
  const paper = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await paper();
  await page.getByRole('button', { name: 'Colours: Auto' }).click();
  await page.getByRole('button', { name: 'Colours: Light' }).click();
  await eventually(async () => assert.notEqual(await paper(), light));
  await page.reload();
  await page.getByRole('button', { name: 'Colours: Dark' }).waitFor();
  await eventually(async () => assert.notEqual(await paper(), light));
}));
