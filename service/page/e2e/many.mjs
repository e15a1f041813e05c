/**
 * How fast a plot of many FRFs answers: ten seconds of zooming and moving, at 1280 x 800.
 *
 * Usage: node e2e/many.mjs ADDRESS TEST, with the id of a test on that service. Prints milliseconds as JSON.
 */

import { withBrowser } from "./browser.mjs";

const [address, test] = process.argv.slice(2);
const SECONDS = 10;

await withBrowser(address, { viewport: { width: 1280, height: 800 } }, async (context) => {
  const page = await context.newPage();
  await page.goto(`${address}/#rig`); // the script and the fonts are loaded: the plot alone is timed
  await page.getByRole("heading", { level: 1 }).waitFor();
  const begin = Date.now();
  await page.goto(`${address}/#measure?t=${test}`);
  await page.locator(".chart canvas").first().waitFor({ timeout: 60_000 });
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const firstPlot = Date.now() - begin;
  await page.waitForTimeout(500);
  const frames = await page.evaluate(play, SECONDS);
  console.log(JSON.stringify({ firstPlot, ...frames }));
});

/** Runs in the page: turns a wheel or presses a key every frame, and times frames and answers. */
async function play(seconds) {
  const plot = document.querySelector(".chart");
  const over = plot.querySelector(".u-over");
  const { width } = over.getBoundingClientRect();
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const intervals = [];
  const answers = [];
  const end = performance.now() + 1000 * seconds;
  let last = await frame();
  for (let i = 0; last < end; i++) {
    const sent = performance.now();
    const deltaY = i % 60 < 30 ? -40 : 40;
    if (i % 4 < 3) over.dispatchEvent(new WheelEvent("wheel", { deltaY, offsetX: width / 3, clientX: 400, bubbles: true, cancelable: true }));
    else plot.dispatchEvent(new KeyboardEvent("keydown", { key: i % 120 < 60 ? "ArrowRight" : "ArrowLeft", shiftKey: true, bubbles: true }));
    const now = await frame();
    intervals.push(now - last);
    last = now;
    // A task after the frame: what the frame had to draw is drawn then.
    await new Promise((done) => {
      const channel = new MessageChannel();
      channel.port1.onmessage = done;
      channel.port2.postMessage(0);
    });
    answers.push(performance.now() - sent);
  }
  const p95 = (values) => Number(values.sort((a, b) => a - b)[Math.floor(0.95 * values.length)].toFixed(1));
  return { frames: intervals.length, frameP95: p95(intervals), answerP95: p95(answers) };
}
