/**
 * A hand on a keyboard: Tab, arrows, Enter, Space and letters. Nothing here moves the focus by script or has a mouse,
 * and every place that the focus comes to has to be seen.
 */

import { assert } from "./checks.mjs";

const MOST = 400; // stops of Tab, which no view has
const STILL = 250; // ms in which nothing is added to the page

/** Have the page note what a mouse or a finger does to it. */
export async function noticePointers(page) {
  await page.addInitScript(() => {
    globalThis.pointers = 0;
    for (const name of ["pointerdown", "mousedown", "touchstart"]) addEventListener(name, () => (globalThis.pointers += 1), true);
  });
}

/** Fail if a mouse or a finger has touched the page since it was loaded. */
export async function noPointer(page) {
  assert((await page.evaluate(() => globalThis.pointers)) === 0, "the page has been touched by a mouse");
}

/** Press Tab until the focus is on what a locator finds; a fault if it never is. */
export async function tabTo(page, locator, key = "Tab") {
  await locator.waitFor({ state: "attached" });
  for (let i = 0; i < MOST; i++) {
    if (await locator.evaluate((element) => element === document.activeElement)) return;
    await page.keyboard.press(key);
    await seen(page);
  }
  throw new Error(`${locator} is not reached by the keyboard`);
}

/** Go to a button or a link, and press Enter. */
export async function press(page, role, name) {
  await tabTo(page, page.getByRole(role, { name, exact: typeof name === "string" }).first());
  await page.keyboard.press("Enter");
}

/** Go to a field by its label, and type in place of what it has. */
export async function type(page, label, text) {
  await tabTo(page, page.getByLabel(label, { exact: true }));
  await page.keyboard.press("Control+a");
  await page.keyboard.type(String(text));
}

/** Go to a list by its label, and from its first entry down to one. */
export async function choose(page, label, text) {
  const list = page.getByRole("combobox", { name: label, exact: true });
  await tabTo(page, list);
  const chosen = () => list.evaluate((element) => element.selectedOptions[0]?.text);
  await page.keyboard.press("Home");
  for (let i = 0; i < MOST && (await chosen()) !== text; i++) await page.keyboard.press("ArrowDown");
  assert((await chosen()) === text, `${label} is at ${await chosen()}, not ${text}`);
}

/** Go to a group of choices, and to one of them by the arrow keys. */
export async function pick(page, group, name) {
  const radios = page.getByRole("group", { name: group, exact: true });
  await tabTo(page, radios.locator("input:checked"));
  const wanted = radios.getByRole("radio", { name, exact: true });
  for (let i = 0; i < 8 && !(await wanted.isChecked()); i++) await page.keyboard.press("ArrowRight");
  assert(await wanted.isChecked(), `${name} of ${group} is not reached by the arrow keys`);
  await seen(page);
}

/** Go round a view with Tab: every control is reached once, in the order of the page, each in sight. */
export async function goRound(page) {
  await settled(page);
  await page.evaluate(() => (globalThis.stops = []));
  for (let i = 0; i < MOST; i++) {
    await page.keyboard.press("Tab");
    await seen(page);
    if (await page.evaluate(hasBeenHere)) break;
  }
  const { count, jumps, missed } = await page.evaluate(roundOf);
  assert(jumps.length === 0, `the focus jumps to ${jumps.join("; ")}`);
  assert(missed.length === 0, `not reached by Tab: ${missed.join("; ")}`);
  return count;
}

/** Return when nothing comes to the page any more. */
async function settled(page) {
  const size = () => page.evaluate(() => document.querySelectorAll("*").length);
  for (let last = -1, now = await size(); now !== last; last = now, now = await size()) await page.waitForTimeout(STILL);
}

/** Fail if the focus is somewhere that nobody sees. */
async function seen(page) {
  const fault = await page.evaluate(faultOfFocus);
  assert(!fault, fault);
}

// What follows runs in the page.

/** Note where the focus is; true where it has been before. */
function hasBeenHere() {
  const at = document.activeElement;
  if (at === document.body) return false; // after the last control, before the first
  if (at === stops.at(-1)) return false; // day, month and year of a date are stops of one control
  return stops.includes(at) || !stops.push(at);
}

/** Return how many controls a round has reached, which against the order of the page, and which it has left out. */
function roundOf() {
  const words = (one) => `${one.tagName.toLowerCase()} ${one.getAttribute("aria-label") ?? one.textContent.trim().slice(0, 30)}`;
  const before = (a, b) => Boolean(a.compareDocumentPosition(b) & Node.DOCUMENT_POSITION_FOLLOWING);
  const first = stops.findIndex((one) => stops.every((other) => other === one || before(one, other)));
  const round = [...stops.slice(first), ...stops.slice(0, first)];
  const back = round.filter((one, i) => i > 0 && !before(round[i - 1], one));
  const names = new Set(stops.filter((one) => one.type === "radio").map((one) => one.name)); // one of a group is enough
  const missed = [...document.querySelectorAll("a[href], button, input, select, textarea, summary, [role=button], [tabindex='0']")]
    .filter((one) => !one.disabled && one.tabIndex >= 0 && one.checkVisibility())
    .filter((one) => !stops.includes(one) && !(one.type === "radio" && names.has(one.name)));
  return { count: stops.length, jumps: back.map(words), missed: missed.map(words) };
}

/** Say what is wrong with where the focus is: it has no mark, or is not in the window. */
function faultOfFocus() {
  const at = document.activeElement;
  if (!at || at === document.body) return null;
  const name = `${at.tagName.toLowerCase()} ${at.getAttribute("aria-label") ?? (at.labels?.[0] ?? at).textContent.trim().slice(0, 30)}`;
  // The mark is on the control, on what is drawn for it, or on the frame around it.
  const marked = [at, at.nextElementSibling, at.querySelector(".target"), at.closest(".input, .drop")].filter(Boolean).some((one) => {
    const style = getComputedStyle(one);
    return (style.outlineStyle !== "none" && parseFloat(style.outlineWidth) > 0) || (one.matches(".target") && style.stroke !== "none");
  });
  if (!marked) return `the focus on ${name} has no mark`;
  const { left, right, top, bottom } = at.getBoundingClientRect();
  const inside = right > 0 && bottom > 0 && left < innerWidth && top < innerHeight;
  return inside ? null : `the focus on ${name} is outside of the window`;
}
