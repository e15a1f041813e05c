/**
 * A student's way through the page, by the keyboard: rig, measure, extract, correlate, diagnose.
 *
 * Usage: node e2e/path.mjs ADDRESS [FOLDER]. Prints what was checked as JSON, a line each.
 */

import { readFileSync } from "node:fs";
import { averageByAverage, noteAverages } from "./averages.mjs";
import { assert, drawn, examine, fill, picture, tabTo } from "./checks.mjs";
import { walk } from "./steps.mjs";

const [address, folder] = process.argv.slice(2);
let shared = ""; // the address of the diagnosis

await walk(address, folder, STEPS());

function STEPS() {
  return [
    ["first load", firstLoad],
    ["rig", rig],
    ["measure", measure],
    ["extract", extract],
    ["correlate", correlate],
    ["diagnose", diagnose],
    ["own files", ownFiles],
    ["shared address", sharedAddress],
    ["errors", errors],
    ["reference", reference],
    ["class", noClass],
    ["saved work", savedWork],
  ];
}

async function firstLoad(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("Network.enable");
  let bytes = 0;
  session.on("Network.loadingFinished", (event) => (bytes += event.encodedDataLength));
  await page.goto(`${address}/`);
  await page.getByRole("heading", { name: "chapter-5-beam" }).waitFor();
  await page.evaluate(() => document.fonts.ready);
  await page.waitForLoadState("networkidle"); // half a second without a request
  assert(bytes < 120_000, `${bytes} bytes are transferred`);
  assert((await page.getByRole("button", { name: /sign/i }).count()) === 0, "a service without keys asks for none");
  return { bytes };
}

async function rig(page) {
  await tabTo(page, "[data-node]");
  await page.keyboard.press("ArrowRight");
  assert((await page.evaluate(() => document.activeElement.dataset.node)) === "2", "an arrow key goes to the next node");
  const accelerometers = () => page.locator('[data-node][aria-pressed="true"]').count();
  const before = await accelerometers();
  await page.keyboard.press("Enter");
  assert((await accelerometers()) === before + 1, "Enter sets an accelerometer");
  await page.keyboard.press("Enter");
  assert((await accelerometers()) === before, "Enter removes it");
  await page.keyboard.press("d");
  assert((await page.locator(".legend-row select").inputValue()) === "2:+Y", "D moves the drive");
  await page.locator('[data-node="1"]').click(); // and the mouse: node 1 loses its accelerometer
  assert((await accelerometers()) === before - 1, "a click removes an accelerometer");
  await page.locator('[data-node="1"]').click();
  await page.locator(".legend-row select").selectOption("1:+Y");
  await page.getByRole("switch", { name: "extra mass" }).focus();
  await page.keyboard.press("Space");
  await page.getByLabel("at", { exact: true }).selectOption("9:+Y");
  await fill(page, "Lines", 401);
  await fill(page, "Averages", 12);
  await examine(page, "rig", folder);
}

async function measure(page) {
  await page.locator("body").press("Home");
  await tabTo(page, "a.next");
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { name: "Frequency responses" }).waitFor();
  await tabTo(page, "button.primary");
  const begin = Date.now();
  await noteAverages(page);
  await page.keyboard.press("Enter");
  await page.locator(".chart canvas").first().waitFor();
  const measured = Date.now() - begin;
  await averageByAverage(page, folder);
  await tabTo(page, ".chart");
  await page.keyboard.press("ArrowRight");
  assert(/\d Hz/.test(await page.locator(".readout-freq").innerText()), "the cursor tells a frequency");
  await page.keyboard.press("+");
  assert((await page.locator(".zoom-range").innerText()) !== "0 – 800 Hz", "plus zooms");
  await page.keyboard.press("0");
  assert((await page.locator(".zoom-range").innerText()) === "0 – 800 Hz", "0 shows all");
  for (const name of ["Phase", "Real", "Imaginary", "Nyquist"]) {
    await page.getByRole("radio", { name }).check({ force: true });
    await drawn(page);
  }
  await picture(page, "measure-nyquist", folder);
  await page.getByRole("radio", { name: "Magnitude" }).check({ force: true });
  const file = page.waitForEvent("download");
  await page.getByRole("button", { name: "CSV" }).click();
  const text = readFileSync(await (await file).path(), "utf8");
  assert(text.split("\n").length === 403, "the table has a line for each of 401 frequencies");
  const python = await page.getByRole("button", { name: "Copy as Python" }).getAttribute("data-python");
  await examine(page, "measure", folder);
  return { measured, python };
}

async function extract(page) {
  await page.locator("a.next").first().press("Enter");
  await page.getByRole("heading", { name: "Modes" }).waitFor();
  const plot = page.locator(".chart .u-over").first();
  const box = await plot.boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 60);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.57 * box.width, box.y + 60, { steps: 4 });
  await page.mouse.up();
  assert((await page.locator(".bands li").count()) === 1, "a dragged band is in the list");
  await page.getByRole("radio", { name: "Found" }).check({ force: true });
  await tabTo(page, "button.primary");
  await page.keyboard.press("Enter");
  await rows(page).first().waitFor();
  const modes = await rows(page).count();
  assert(modes === 8, `${modes} modes are found, of 8 below 800 Hz`);
  await choosePoles(page);
  await page.getByLabel("Method", { exact: true }).selectOption("together");
  await page.getByRole("button", { name: "Extract", exact: true }).press("Enter");
  await page.locator('[aria-label="Table of fits"] tbody tr').nth(2).waitFor(); // circle, line, Dobson
  assert((await page.locator(".small-figure svg").count()) === 5, "circle, damping surface, line, fan and slopes are drawn");
  const fits = await page.locator('[aria-label="Table of fits"] tbody tr').allInnerTexts();
  assert((await rows(page).count()) === 8, "all modes are there again");
  await page.getByRole("button", { name: "Take the 8 bands found" }).press("Enter");
  assert((await page.locator(".bands li").count()) === 8, "the bands found are in the list");
  await page.getByRole("button", { name: "Show mode 3" }).press("Enter");
  await page.locator(".measured-shape circle").first().waitFor();
  await page.getByText(/model mode 3/).waitFor();
  const python = await page.getByRole("button", { name: "Copy as Python" }).getAttribute("data-python");
  await examine(page, "extract", folder);
  return { modes, fits, python };
}

function rows(page) {
  return page.locator('[aria-label="Table of modes"] tbody tr');
}

/** Choose modes in a stabilisation chart: by a click on a pole, and by the keyboard. */
async function choosePoles(page) {
  await page.getByLabel("Method", { exact: true }).selectOption("lscf");
  await page.getByRole("button", { name: "Extract", exact: true }).press("Enter");
  await page.locator(".poles").waitFor();
  await page.locator('.pole[data-mode="2"] .mark').last().click();
  assert(/^Pole at .* Hz, loss factor .*; of mode 2\.$/.test(await page.locator(".stabilisation .readout").innerText()), "a clicked pole is told");
  await tabTo(page, '.stabilisation .chip:nth-of-type(8) input');
  await page.keyboard.press("Space");
  await examine(page, "stabilisation", folder);
  await page.getByRole("button", { name: "Keep 6 of 8 modes" }).press("Enter");
  await page.waitForFunction(() => document.querySelectorAll('[aria-label="Table of modes"] tbody tr').length === 6);
}

async function correlate(page) {
  await page.locator("a.next").first().press("Enter");
  await page.locator(".mac svg").waitFor();
  await tabTo(page, "button.primary");
  await page.keyboard.press("Enter");
  await page.locator(".bars").waitFor();
  assert((await page.locator(".small-figure .figure-line").count()) > 4, "coefficients are drawn by iteration");
  const python = await page.getByRole("button", { name: "Copy as Python" }).getAttribute("data-python");
  await examine(page, "correlate", folder);
  return { python };
}

async function diagnose(page) {
  await page.locator("a.next").first().press("Enter");
  await tabTo(page, "button.primary");
  await page.keyboard.press("Enter");
  await page.locator(".verdict").waitFor({ timeout: 300_000 }); // alone it takes five seconds
  const verdict = await page.locator(".verdict").innerText();
  assert(verdict.includes("extra mass at 9:+Y"), verdict);
  await page.locator(".chart canvas").first().waitFor();
  const python = await page.getByRole("button", { name: "Copy as Python" }).getAttribute("data-python");
  await examine(page, "diagnose", folder);
  shared = page.url();
  return { verdict, python };
}

async function ownFiles(page) {
  const test = /[?&]t=([^&,]+)/.exec(page.url())[1];
  const file = await page.request.get(`${address}/v1/measurements/${test}/frf.uff`);
  await page.getByLabel("Drop FRFs here, or choose files").setInputFiles({ name: "own.uff", mimeType: "application/octet-stream", buffer: await file.body() });
  await page.waitForFunction((old) => !location.hash.includes(old), test);
  const model = { kind: "beam", length: 1, n_elements: 8, section: { area: 5e-4, second_moment: 4e-9 }, material: { modulus: 2e11, density: 7800 } };
  await page.getByLabel("Drop a model here").setInputFiles({ name: "model.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify(model)) });
  await page.getByText("Not diagnosed yet").waitFor();
}

async function sharedAddress(page) {
  const other = await page.context().newPage();
  await other.goto(shared);
  const verdict = other.locator(".verdict");
  await verdict.waitFor();
  assert((await verdict.innerText()).includes("extra mass"), "a shared address shows the diagnosis");
  assert(!shared.includes("extra_mass"), "the address tells no hidden effect");
  await other.close();
}

async function errors(page, faults) {
  await page.goto(`${address}/#measure?s=none&t=none`);
  await page.getByRole("alert").first().waitFor();
  await examine(page, "error", folder);
  await page.goto(`${address}/#diagnose`);
  await page.getByText("A model and a test are needed").waitFor();
  const refused = faults.splice(0); // the browser writes every refused request to its console
  assert(refused.length > 0 && refused.every((fault) => fault.includes("404")), refused.join("; "));
}

async function reference(page) {
  await page.goto(`${address}/docs`);
  await page.getByText("Create a structure").first().waitFor();
  await picture(page, "reference", folder);
}

/** A service without keys has no classes, and asks for no key. */
async function noClass(page) {
  await page.goto(`${address}/#class`);
  await page.getByRole("heading", { name: "A class needs keys" }).waitFor();
  assert((await page.getByRole("button", { name: /sign/i }).count()) === 0, "a service without keys asks for none");
  await examine(page, "class", folder);
}

/** What was stored on the way is found again, deleted, restored, opened, and taken along as a file. */
async function savedWork(page) {
  await page.goto(`${address}/#rig`);
  await page.getByRole("button", { name: "Saved work" }).press("Enter");
  const dialog = page.getByRole("dialog", { name: "Saved work" });
  const rows = dialog.locator(".saved-list li");
  const show = async (kind) => {
    await dialog.getByRole("radio", { name: kind }).check({ force: true });
    await dialog.getByRole("list", { name: kind }).waitFor();
  };
  await show("Tests");
  assert((await rows.count()) === 2, "the test and its copy from a file are listed");
  await rows.first().getByRole("button", { name: /^Rename/ }).press("Enter");
  await dialog.locator("input:focus").first().waitFor();
  await page.keyboard.type("Own files");
  await page.keyboard.press("Enter");
  await dialog.getByText("Renamed.").waitFor();
  await rows.first().getByText(/^Own files/).waitFor(); // the list is read again
  await examine(page, "saved-work", folder);
  await show("Diagnoses");
  const diagnoses = await rows.count();
  await rows.first().getByRole("button", { name: /^Delete/ }).press("Enter");
  await dialog.getByText("Moved to the trash").waitFor();
  await show("Trash");
  await rows.first().getByRole("button", { name: /^Restore/ }).press("Enter");
  await dialog.getByText("Restored.").waitFor();
  await show("Diagnoses");
  assert((await rows.count()) === diagnoses, "the diagnosis is back");
  const saving = page.waitForEvent("download");
  await dialog.getByRole("button", { name: "Save all as a file" }).press("Enter");
  const project = readFileSync(await (await saving).path());
  await dialog.getByLabel("Add a project file").setInputFiles({ name: "project.zip", mimeType: "application/zip", buffer: project });
  const added = await dialog.getByText(/^Added:/).innerText();
  assert(added.includes("diagnosis: 1"), added);
  await rows.first().getByRole("button", { name: /^Open/ }).press("Enter");
  await page.locator(".verdict").waitFor();
  assert((await dialog.count()) === 0, "the dialog closes when a result is opened");
  assert((await page.locator(".verdict").innerText()).includes("extra mass"), "the diagnosis is shown again");
  return { added };
}
