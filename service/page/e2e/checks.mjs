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

/** Serious violations of WCAG that axe-core finds. */
export async function seriousViolations(page) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  return violations
    .filter((violation) => ["serious", "critical"].includes(violation.impact))
    .map((violation) => `${violation.id}: ${violation.nodes.slice(0, 3).map((node) => node.target.join(" ")).join(", ")}`);
}

/** Check a view in both lights and at the width of a phone, and keep its pictures. */
export async function examine(page, name, folder) {
  for (const light of LIGHTS) {
    await page.emulateMedia({ colorScheme: light, reducedMotion: "reduce" });
    await page.waitForTimeout(150);
    const found = await seriousViolations(page);
    assert(found.length === 0, `${name}, ${light}: ${found.join("; ")}`);
    await page.screenshot({ path: `${folder}/${name}-${light}.png`, fullPage: true });
  }
  await page.emulateMedia({ colorScheme: "light" });
  await page.setViewportSize(PHONE);
  await page.waitForTimeout(200);
  const wide = await page.evaluate(overflow);
  await page.screenshot({ path: `${folder}/${name}-phone.png`, fullPage: true });
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
