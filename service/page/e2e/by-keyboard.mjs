/**
 * Every view used by the keyboard alone, on a service with keys: sign in, set up a rig, measure, extract, correlate,
 * update, diagnose and go on, hold a class, answer as a student.
 *
 * Usage: KEY=... node e2e/by-keyboard.mjs ADDRESS [FOLDER], with an instructor's key. Prints what was checked as JSON.
 */

import { readFileSync } from "node:fs";
import { assert, examine, reload } from "./checks.mjs";
import { choose, goRound, noPointer, noticePointers, pick, press, tabTo, type } from "./keyboard.mjs";
import { walk } from "./steps.mjs";

const [address, folder] = process.argv.slice(2);
const { KEY } = process.env; // not an argument: those are seen by every user of the machine
const STUDENT = "Student by keys";
let studentKey = ""; // out of the file that the instructor saves

const heading = (page, name) => page.getByRole("heading", { name, exact: true }).waitFor();
const rows = (page, table) => page.locator(`[aria-label="${table}"] tbody tr`);

await walk(address, folder, STEPS(), { tolerated: "401", before: noticePointers, after: noPointer, secret: KEY });

function STEPS() {
  return [
    ["sign in", signIn],
    ["plate", plate],
    ["rig", rig],
    ["measure", measure],
    ["extract", extract],
    ["poles", poles],
    ["correlate", correlate],
    ["diagnose", diagnose],
    ["class", holdClass],
    ["student", answer],
  ];
}

async function enter(page, key, name) {
  await page.getByRole("dialog", { name: "Sign in" }).waitFor();
  await type(page, "Key", key);
  await page.keyboard.press("Enter");
  await page.locator(".account-name", { hasText: name }).waitFor();
}

async function signOut(page) {
  await reload(page, () => press(page, "button", "Sign out"));
  await page.getByRole("dialog", { name: "Sign in" }).waitFor();
}

async function signIn(page) {
  await page.goto(`${address}/#rig`);
  await enter(page, KEY, "Lecturer by keys");
  await heading(page, "chapter-5-beam");
  await page.keyboard.press("Tab");
  if (await page.evaluate(() => document.activeElement.className !== "skip")) await tabTo(page, page.getByRole("link", { name: "Skip to the view" }));
  await page.keyboard.press("Enter");
  assert(await page.evaluate(() => document.activeElement.id === "main"), "the first link leads past the header");
}

/** The shape of a plate is turned. */
async function plate(page) {
  await choose(page, "Example", "plate");
  await heading(page, "plate");
  await type(page, "Lines", 201);
  await type(page, "Averages", 5);
  await press(page, "link", "Measure"); // in the header
  await press(page, "button", "Start the test");
  await page.locator(".chart canvas").first().waitFor();
  await press(page, "link", /^Extract modes/);
  await press(page, "button", "Extract");
  await press(page, "button", "Hold");
  const shape = page.locator(".in-space");
  const drawing = () => shape.locator(".surface path").first().getAttribute("d");
  await tabTo(page, shape, "Shift+Tab");
  const before = await drawing();
  for (const key of ["ArrowRight", "ArrowUp"]) await page.keyboard.press(key);
  await page.waitForFunction((old) => document.querySelector(".surface path").getAttribute("d") !== old, before);
  await page.keyboard.press("0");
  await page.waitForFunction((old) => document.querySelector(".surface path").getAttribute("d") === old, before);
  const stops = await goRound(page);
  await examine(page, "plate", folder);
  await press(page, "link", "Rig");
  return { stops };
}

/** Another structure, the hammer, an accelerometer, the drive, a hidden effect, the analyser. */
async function rig(page) {
  const stops = await goRound(page);
  assert(stops < 80, `${stops} stops: of the nodes only one is to be among them`);
  await choose(page, "Example", "chapter 5 beam");
  await heading(page, "chapter-5-beam");
  await tabTo(page, page.locator('[data-node="1"]'));
  const sensors = () => page.locator('[data-node][aria-pressed="true"]').count();
  const before = await sensors();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  assert((await sensors()) === before + 1, "Enter sets an accelerometer");
  await page.keyboard.press("Space");
  assert((await sensors()) === before, "Space removes it");
  await pick(page, "Exciter", "Hammer");
  await tabTo(page, page.locator('[data-node="2"]'));
  await page.keyboard.press("d");
  assert((await page.locator(".node.driven").getAttribute("data-node")) === "2", "D moves the hammer");
  await choose(page, "Drive", "1:+Y");
  await pick(page, "Exciter", "Shaker");
  await tabTo(page, page.getByRole("switch", { name: "extra mass" }));
  await page.keyboard.press("Space");
  await choose(page, "at", "9:+Y");
  await type(page, "Lines", 401);
  await type(page, "Averages", 12);
  return { stops };
}

async function measure(page) {
  await press(page, "link", "Measure"); // in the header
  await heading(page, "Frequency responses");
  await press(page, "button", "Start the test");
  await page.locator(".chart canvas").first().waitFor();
  await tabTo(page, page.locator(".signals summary"));
  await page.keyboard.press("Enter");
  await page.locator(".signals .figure-line").nth(3).waitFor(); // record and spectrum of force and response
  await choose(page, "Response of the signals", "5:+Y");
  const stops = await goRound(page);
  await tabTo(page, page.locator(".chart").first());
  await page.keyboard.press("ArrowRight");
  assert(/\d Hz/.test(await page.locator(".readout-freq").innerText()), "an arrow key moves the cursor");
  await page.keyboard.press("+");
  const zoomed = await page.locator(".zoom-range").innerText();
  await page.keyboard.press("Shift+ArrowRight");
  assert(zoomed !== (await page.locator(".zoom-range").innerText()), "Shift with an arrow key moves the range");
  await page.keyboard.press("0");
  for (const name of ["Phase", "Real", "Imaginary", "Nyquist", "Magnitude"]) await pick(page, "Representation", name);
  await pick(page, "Scale", "Linear");
  await examine(page, "signals", folder);
  await tabTo(page, page.locator(".responses .chip input").first());
  await page.keyboard.press("Space");
  assert((await page.locator(".responses summary").innerText()).startsWith("10 of 11"), "a response is left out");
  return { stops };
}

/** A band is typed in, and a mode is fitted in it. */
async function extract(page) {
  await press(page, "link", /^Extract modes/);
  await heading(page, "Modes");
  await choose(page, "Method", "circle fit");
  await pick(page, "Bands", "Mine");
  await type(page, "From", 55);
  await type(page, "To", 75);
  await press(page, "button", "Add the band");
  await press(page, "button", "Extract");
  await rows(page, "Table of modes").first().waitFor();
  const modes = await rows(page, "Table of modes").count();
  await page.locator('[aria-label="Table of fits"] tbody tr').first().waitFor();
  await press(page, "button", "Move"); // shapes rest where little motion is asked for, as `examine` has
  const stops = await goRound(page);
  return { modes, stops };
}

/** The modes of the whole range by a global method; poles are chosen in its stabilisation chart. */
async function poles(page) {
  await choose(page, "Method", "lscf");
  await pick(page, "Bands", "Found");
  await press(page, "button", "Extract");
  await page.locator(".poles").waitFor();
  await tabTo(page, page.locator(".stabilisation .chip input").last());
  await page.keyboard.press("Space");
  await press(page, "button", /^Keep 7 of 8 modes$/);
  await page.waitForFunction(() => document.querySelectorAll('[aria-label="Table of modes"] tbody tr').length === 7);
  await press(page, "button", "Show mode 3");
  await page.locator('button[aria-label="Show mode 3"][aria-pressed="true"]').waitFor();
  return { stops: await goRound(page) };
}

async function correlate(page) {
  await press(page, "link", /^Correlate/);
  await page.locator(".mac svg").waitFor();
  await press(page, "button", "Update the model");
  await page.locator(".bars").waitFor();
  const stops = await goRound(page);
  await pick(page, "Coefficients", await page.locator(".choice input:not(:checked) + span").first().innerText());
  return { stops };
}

/** The effect that is found is added to the model, and nothing is missing then. */
async function diagnose(page) {
  await press(page, "link", /^Diagnose/);
  await heading(page, "Diagnosis");
  await press(page, "button", "Start the diagnosis");
  await page.locator(".verdict").waitFor({ timeout: 300_000 }); // alone it takes five seconds
  const verdict = await page.locator(".verdict").innerText();
  await page.locator(".chart canvas").first().waitFor();
  const stops = await goRound(page);
  await press(page, "button", /^Go on with the model that has extra mass/);
  await page.getByText("Not diagnosed yet").waitFor();
  await press(page, "button", "Start the diagnosis");
  await page.locator(".verdict.nothing_missing").waitFor({ timeout: 300_000 });
  return { verdict, stops };
}

async function holdClass(page) {
  await press(page, "link", "Class");
  await heading(page, "No class yet");
  await type(page, "Name of the class", "Keys");
  await press(page, "button", "Create the class");
  await heading(page, "Keys");
  await type(page, "Names, one a line", STUDENT);
  const saved = page.waitForEvent("download");
  await press(page, "button", "Make 1 key");
  studentKey = readFileSync(await (await saved).path(), "utf8").trim().split(/\r?\n/)[1].split(",")[2];
  await type(page, "Title", "By the keyboard");
  await choose(page, "Diagnosis", "allowed");
  const stops = await goRound(page);
  await press(page, "button", "Hand out the assignment");
  await page.getByText("0 of 1 have measured, 0 have submitted.").waitFor();
  await signOut(page);
  return { stops };
}

async function answer(page) {
  await enter(page, studentKey, STUDENT);
  await press(page, "link", "Class");
  await page.getByText("5 of 5 tests left, 1 of 1 answers left.").waitFor();
  await type(page, "Averages", 20);
  await press(page, "button", "Measure");
  await page.getByText("4 of 5 tests left").waitFor();
  await choose(page, "Effect", "extra mass");
  await press(page, "button", "Add the effect");
  await type(page, "Point", "9:+Y");
  const stops = await goRound(page);
  await press(page, "button", "Submit, the last answer");
  await page.locator(".marks").waitFor();
  const points = await page.locator(".marks h2").innerText();
  await signOut(page);
  return { points, stops };
}
