/** Makes the pictures of the README: node make.mjs http://127.0.0.1:8480 (a daemon with its dashboard). */

import { chromium } from 'playwright-core';

const [url] = process.argv.slice(2);
const here = new URL('.', import.meta.url).pathname;

const pictures = [
  ['solve', '#run/solve?case=smith-hutton&go=1&motion=velocity', { width: 1280, height: 800 }, 'light', '.hands'],
  ['study', '#run/study?study=gartland&go=1', { width: 1280, height: 1000 }, 'light', '.plot-slope'],
  ['narrow', '#run/solve?case=heat&go=1&step=5', { width: 390, height: 844 }, 'dark', '.hands'],
];

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
for (const [name, path, viewport, colorScheme, ready] of pictures) {
  const page = await browser.newPage({ viewport, colorScheme });
  await page.goto(`${url}/${path}`);
  await page.locator(ready).first().waitFor();
  await page.waitForTimeout(4000);
  await page.screenshot({ path: `${here}${name}.png` });
  await page.close();
}
await browser.close();
