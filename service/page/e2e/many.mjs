/**
 * How fast a plot of many FRFs answers: ten seconds of zooming and moving, at 1280 x 800.
 *
 * Usage: node e2e/many.mjs ADDRESS TEST SHARE, with the id of a test on that service, and where in its range a line
 * of one FRF stands high above all others. Prints as JSON milliseconds, how many curves the page says it draws, and
 * how far the line stands out in pixels, and in those beside it.
 */

import { withBrowser } from "./browser.mjs";

const [address, test, share] = process.argv.slice(2);
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
  const says = await page.getByText(/^All \d+ curves are drawn/).innerText();
  const spike = await page.evaluate(inkAbove, Number(share));
  const frames = await page.evaluate(play, SECONDS);
  console.log(JSON.stringify({ firstPlot, says, ...spike, ...frames }));
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

/** Runs in the page: rows of the upper third of the plot that are inked where a line is, and a little beside it. */
function inkAbove(share) {
  const plot = document.querySelector(".chart");
  const canvas = plot.querySelector("canvas");
  const [frame, over] = [canvas, plot.querySelector(".u-over")].map((one) => one.getBoundingClientRect());
  const scale = canvas.width / frame.width;
  const [left, top] = [(over.left - frame.left) * scale, (over.top - frame.top) * scale];
  const dark = (data, i) => data[i + 3] > 100 && data[i] + data[i + 1] + data[i + 2] < 400; // the grid is light
  const rows = (column) => {
    const { data } = canvas.getContext("2d").getImageData(Math.round(column), Math.round(top), 1, Math.round((over.height * scale) / 3));
    return Array.from({ length: data.length / 4 }, (_, i) => dark(data, 4 * i)).filter(Boolean).length;
  };
  const at = left + share * over.width * scale;
  return { spike: Math.max(...[-1, 0, 1].map((by) => rows(at + by))), beside: Math.max(rows(at - 12), rows(at + 12)) };
}
