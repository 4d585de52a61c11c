/** A million points: drawn, and moved about. Times are printed, not asserted: this machine may be
 *  busy, and has no graphics card (SwiftShader draws on the processor). What is asserted is that
 *  moving does not draw the points again. */

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawn, likeness, linkTo, looksOther, withPage } from './page.mjs';

const million = {
  cloud: { lattice: { lower: [0, 0], upper: [1, 1], cells: [999, 999], jitter: 0.2, seed: 1 } },
  diffusivity: 1,
  initial: 'sin(2*pi*x) * sin(pi*y)',
  time: { method: 'forward-euler', end: 1e-8, step: 1e-8 },
  boundary: [{ on: 'boundary', type: 'dirichlet', value: 0 }],
};

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

/** Intervals between frames while `act` goes on (ms). */
async function frames(page, act) {
  await page.evaluate(() => {
    window.frameTimes = [];
    let last = performance.now();
    const tick = (now) => {
      window.frameTimes.push(now - last);
      last = now;
      window.frameLoop = requestAnimationFrame(tick);
    };
    window.frameLoop = requestAnimationFrame(tick);
  });
  await act();
  return page.evaluate(() => {
    cancelAnimationFrame(window.frameLoop);
    return window.frameTimes.slice(1);
  });
}

test('a million points are drawn and moved', () => withPage(async ({ page, daemon }) => {
  let arrived = 0;
  page.on('requestfinished', (request) => {
    if (request.url().includes('execution')) arrived = Date.now();
  });
  await page.goto(`${daemon.url}/${linkTo('solve', million, { go: '1' })}`);
  await drawn(page, 1_000_000);
  const wait = Date.now() - arrived;
  await page.waitForTimeout(1500);
  const once = await page.locator('.canvas canvas').first().getAttribute('data-drawn');
  const box = await page.locator('.hands').boundingBox();
  const still = await frames(page, () => page.waitForTimeout(1500));

  const start = await likeness(page);
  const move = () => frames(page, () => page.evaluate(async () => {
    const hands = document.querySelector('.hands');
    hands.setPointerCapture = () => undefined;
    const area = hands.getBoundingClientRect();
    const send = (type, k) => hands.dispatchEvent(new PointerEvent(type, {
      pointerId: 1, bubbles: true, clientX: area.left + 300 + 80 * Math.sin(k / 10), clientY: area.top + 200 + 40 * Math.cos(k / 13),
    }));
    send('pointerdown', 0);
    for (let k = 1; k < 90; k++) {
      await new Promise(requestAnimationFrame);
      send('pointermove', k);
    }
    send('pointerup', 90);
  }));
  let drag = await move();
  // who draws them again is never quicker, also where others have the processors for a while
  for (let more = 0; more < 4 && median(drag) >= 0.8 * Number(once); more++) drag = await move();
  await looksOther(page, start);
  console.log(`a million points: on screen ${wait} ms after the result came; one drawing ${once} ms; ` +
    `frames while dragging: median ${median(drag).toFixed(1)} ms, at rest ${median(still).toFixed(1)} ms`);
  assert.ok(median(drag) < 0.8 * Number(once), 'moving draws the points again');
  assert.ok(box.width > 500);
}));
