/** A daemon and its page in Chromium. What the page must never do is watched all along: errors in
 *  the console, exceptions, requests to anybody but the daemon. */

import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { deflateRawSync } from 'node:zlib';
import { startDaemon } from '../../clients/js/test/daemon.js';

const web = process.env.SCATTERD_WEB;
export const need = createRequire(join(web, 'package.json'));
const { chromium } = need('playwright-core');

/** Anything may take this long on a busy machine (milliseconds). */
export const patience = Number(process.env.PATIENCE ?? 60_000);

export function launch() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}

export async function withPage(act, { daemon: settings, refusals = false, away = false, ...view } = {}) {
  const daemon = await startDaemon(settings);
  const browser = await launch();
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, acceptDownloads: true, ...view });
  await context.grantPermissions(['clipboard-read', 'clipboard-write'], { origin: daemon.url });
  const page = await context.newPage();
  page.setDefaultTimeout(patience);
  const faults = watch(page, new URL(daemon.url).host, { refusals, away });
  try {
    await act({ page, daemon, faults });
    assert.deepEqual(faults, []);
  } finally {
    await browser.close();
    await daemon.stop();
  }
}

/** Chromium itself writes a line for every refused request and for every lost connection. */
function watch(page, host, { refusals, away }) {
  const faults = [];
  const expected = (text) =>
    (refusals && /status of 4\d\d/.test(text)) || (away && /ERR_|status of 503/.test(text));
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !expected(message.text())) faults.push(message.text());
  });
  page.on('pageerror', (error) => faults.push(error.stack));
  page.on('request', (request) => {
    const url = new URL(request.url());
    if (!['blob:', 'data:'].includes(url.protocol) && url.host !== host) faults.push(`request to ${url.host}`);
  });
  return faults;
}

/** The link to a problem, as the page makes it. */
export function linkTo(process, inputs, more = {}) {
  const r = deflateRawSync(JSON.stringify({ process, inputs })).toString('base64url');
  return `#run/${process}?${new URLSearchParams({ r, ...more })}`;
}

/** The control in the label that begins with this word. */
export function pick(page, word) {
  return page.locator('label.pick', { has: page.getByText(word, { exact: true }) }).locator('select, input');
}

/** Waits until a cloud of so many points is drawn. */
export function drawn(page, points) {
  return page.waitForFunction(
    (wanted) => [...document.querySelectorAll('.canvas canvas')].some((canvas) => canvas.dataset.points === String(wanted)),
    points, { timeout: patience });
}

/** What a check asserts holds in the end: for what the page does in its own time. */
export async function eventually(check) {
  const end = Date.now() + patience;
  for (;;) {
    try {
      return await check();
    } catch (error) {
      if (Date.now() > end) throw error;
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
  }
}

/** Pixels of the points' canvas, [height][width] with four bytes each. */
export function pixels(page) {
  return page.evaluate(() => {
    const canvas = document.querySelector('.canvas canvas');
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0);
    const { data, width, height } = context.getImageData(0, 0, copy.width, copy.height);
    return { data: Array.from(data), width, height };
  });
}

/** A picture in short: equal if the points' canvas is. */
export function likeness(page) {
  return page.evaluate(async () => {
    const bytes = new TextEncoder().encode(document.querySelector('.canvas canvas').toDataURL());
    return Array.from(new Uint8Array(await crypto.subtle.digest('SHA-256', bytes))).join();
  });
}

/** The likeness of a picture that has come to rest. */
export async function atRest(page) {
  for (let before = null; ;) {
    const now = await likeness(page);
    if (now === before) return now;
    before = now;
    await page.waitForTimeout(600);
  }
}

export const looksLike = (page, other) => eventually(async () => assert.equal(await likeness(page), other));
export const looksOther = (page, than) => eventually(async () => assert.notEqual(await likeness(page), than));

export const unitSquare = (cells, jitter = 0.2) => ({ lattice: { lower: [0, 0], upper: [1, 1], cells: [cells, cells], jitter, seed: 1 } });

export const heat = {
  cloud: unitSquare(20),
  diffusivity: 1,
  initial: 'sin(pi*x) * sin(pi*y)',
  time: { method: 'backward-euler', end: 0.1, step: 0.01, save: [0, 0.05, 0.1] },
  boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }],
  exact: 'sin(pi*x) * sin(pi*y) * exp(-2*pi^2*t)',
};

/** Runs for minutes, and says how far it is. */
export const long = { ...heat, cloud: unitSquare(60), time: { method: 'backward-euler', end: 1, step: 2e-6 } };
