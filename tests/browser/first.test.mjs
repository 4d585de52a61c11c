/** The first view: what it weighs, how it is cached, what it may do. */

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { withPage } from './page.mjs';

const budget = 400_000; // bytes on the wire
const browser = { Accept: 'text/html,application/xhtml+xml,*/*;q=0.8', 'Accept-Encoding': 'gzip, deflate, br' };

test('the catalogue appears, within the budget', () => withPage(async ({ page, daemon }) => {
  let weight = 0;
  page.on('response', async (response) => {
    const { responseBodySize, responseHeadersSize } = await response.request().sizes();
    weight += responseBodySize + responseHeadersSize;
  });
  const began = Date.now();
  await page.goto(daemon.url);
  await page.getByRole('heading', { name: 'A front carried round a bend', exact: true }).waitFor();
  const seen = Date.now() - began;
  await page.waitForLoadState('networkidle');
  assert.equal(await page.locator('.case').count(), 6);
  assert.ok(weight > 20_000 && weight < budget, `${weight} bytes`);
  console.log(`first view: ${weight} bytes, there after ${seen} ms`);
}));

test('the page is asked for anew, what it loads is kept for ever', () => withPage(async ({ daemon }) => {
  const page = await fetch(daemon.url, { headers: browser });
  assert.equal(page.headers.get('Content-Encoding'), 'gzip');
  assert.equal(page.headers.get('Cache-Control'), 'no-cache');
  const etag = page.headers.get('ETag');
  const again = await fetch(daemon.url, { headers: { ...browser, 'If-None-Match': etag } });
  assert.equal(again.status, 304);
  assert.equal(await again.text(), '');
  const files = [...(await page.text()).matchAll(/(?:src|href)="\.\/(assets\/[^"]+)"/g)].map(([, path]) => path);
  assert.ok(files.some((path) => path.endsWith('.js')) && files.some((path) => path.endsWith('.css')));
  for (const path of files) {
    assert.match(path, /-[\w-]{8}\.\w+$/);
    const [packed, plain] = await Promise.all([browser, { 'Accept-Encoding': 'identity' }].map((headers) => fetch(`${daemon.url}/${path}`, { headers })));
    assert.match(packed.headers.get('Cache-Control'), /max-age=31536000, immutable/);
    assert.equal(plain.headers.get('Content-Encoding'), null);
    assert.equal(packed.headers.get('ETag'), plain.headers.get('ETag'));
    assert.equal(await packed.text(), await plain.text());
  }
  assert.equal((await fetch(`${daemon.url}/assets/nothing.js`)).status, 404);
}));

test('the policy allows nothing inline, nothing evaluated, nobody else', () => withPage(async ({ page, daemon, faults }) => {
  const reply = await page.goto(daemon.url);
  const policy = reply.headers()['content-security-policy'];
  assert.match(policy, /default-src 'none'/);
  assert.doesNotMatch(policy, /unsafe|\*/);
  const blocked = await page.evaluate(async () => {
    const tries = [
      () => document.createElement('script').setAttribute.call(document.body, 'onclick', 'window.hit = 1') ?? document.body.click(),
      () => document.body.append(Object.assign(document.createElement('script'), { textContent: 'window.hit = 2' })),
    ];
    for (const act of tries) act();
    return window.hit === undefined && fetch('http://127.0.0.2:9/').then(() => false, () => true);
  });
  assert.ok(blocked);
  assert.ok(faults.length >= 3 && faults.every((text) => /Content Security Policy|127\.0\.0\.2/.test(text)), faults.join('\n'));
  faults.length = 0;
}));

test('JSON stays the default', () => withPage(async ({ daemon }) => {
  const reply = await fetch(daemon.url);
  assert.equal(reply.headers.get('Content-Type'), 'application/json');
  assert.equal((await reply.json()).title, 'scatterd');
}));
