/** Checks of a view: what every one of them has to be. */

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

export const LIGHTS = ["light", "dark"];
export const PHONE = { width: 400, height: 860 };
export const DESK = { width: 1280, height: 860 };

export function assert(truth, words) {
  if (!truth) throw new Error(words);
}

// What depends on colours. The other rules see what is in the page, which is the same in both lights.
const OF_COLOURS = ["color-contrast", "link-in-text-block"];

/** Serious violations of WCAG that axe-core finds, by all of its rules or some. */
async function seriousViolations(page, rules) {
  if (!(await page.evaluate(() => "axe" in globalThis))) await page.evaluate(AXE);
  const options = { resultTypes: ["violations"], ...(rules && { runOnly: { type: "rule", values: rules } }) };
  const { violations } = await page.evaluate((chosen) => globalThis.axe.run(document, chosen), options);
  return violations
    .filter((violation) => ["serious", "critical"].includes(violation.impact))
    .map((violation) => `${violation.id}: ${violation.nodes.slice(0, 3).map((node) => node.target.join(" ")).join(", ")}`);
}

/** Return when what has changed is drawn: a frame tells the plots their size, the next one draws them. */
export const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));

/** Do what makes the page load itself anew, and return when the new one is there: what is asked of the old one fails. */
export async function reload(page, action) {
  const loaded = page.waitForEvent("load");
  await action();
  await loaded;
}

/** Keep a picture of the whole page, where somebody wants to look at it. */
export async function picture(page, name, folder) {
  if (folder) await page.screenshot({ path: `${folder}/${name}.png`, fullPage: true });
}

/** Check a view in both lights and at the width of a phone. */
export async function examine(page, name, folder) {
  for (const light of LIGHTS) {
    await page.emulateMedia({ colorScheme: light, reducedMotion: "reduce" });
    await drawn(page);
    const found = await seriousViolations(page, light === "light" ? undefined : OF_COLOURS);
    assert(found.length === 0, `${name}, ${light}: ${found.join("; ")}`);
    await picture(page, `${name}-${light}`, folder);
  }
  await page.emulateMedia({ colorScheme: "light" });
  await page.setViewportSize(PHONE);
  await drawn(page);
  const wide = await page.evaluate(overflow);
  await picture(page, `${name}-phone`, folder);
  assert(wide.length === 0, `${name} at 400 px: ${wide.join("; ")} overflow`);
  await page.setViewportSize(DESK);
}

/** Runs in the page: elements that reach beyond the window, unless they scroll by themselves. */
function overflow() {
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth <= width) return [];
  return [...document.querySelectorAll("body *")]
    .filter((element) => element.getBoundingClientRect().right > width + 1)
    .slice(0, 3)
    .map((element) => `${element.tagName.toLowerCase()}.${element.getAttribute("class")}`);
}

/** Press Tab until an element that fits has the focus; a fault if none ever has. */
export async function tabTo(page, selector, most = 160) {
  for (let i = 0; i < most; i++) {
    if (await page.evaluate((wanted) => document.activeElement?.matches(wanted), selector)) return;
    await page.keyboard.press("Tab");
  }
  throw new Error(`${selector} is not reached by the keyboard`);
}

/** Type a number into the field of a label, with the keyboard alone. */
export async function fill(page, label, value) {
  const id = await page.getByLabel(label, { exact: true }).getAttribute("id");
  await tabTo(page, `[id="${id}"]`);
  await page.keyboard.press("Control+a");
  await page.keyboard.type(String(value));
}
