/**
 * A whole class on the page: an instructor seals an assignment for three students, each of them measures,
 * extracts, answers and gets marks, and the instructor sees them.
 *
 * Usage: KEY=... node e2e/class.mjs ADDRESS [FOLDER], with an instructor's key. Prints what was checked as JSON.
 */

import { readFileSync } from "node:fs";
import { assert, examine, fill, reload, tabTo } from "./checks.mjs";
import { walk } from "./steps.mjs";

const [address, folder] = process.argv.slice(2);
const { KEY } = process.env; // not an argument: those are seen by every user of the machine
const STUDENTS = ["Student one", "Student two", "Student three"];
const keys = {}; // by name, out of the file that the instructor saves
const links = {};

await walk(address, folder, STEPS(), { tolerated: "401" }); // before somebody signs in

function STEPS() {
  return [
    ["keys", handOutKeys],
    ["assignment", handOutAssignment],
    ["student one", (page) => student(page, 0, byDiagnosis)],
    ["student two", (page) => student(page, 1, (on) => byHand(on, "extra_mass", "13:+Y"))],
    ["student three", (page) => student(page, 2, (on) => byHand(on, "ground_spring", "9:+Y"))],
    ["marks", seeMarks],
    ["link", useLink],
  ];
}

async function signIn(page, key, name) {
  await page.getByLabel("Key", { exact: true }).fill(key);
  await page.keyboard.press("Enter");
  await page.locator(".account-name", { hasText: name }).waitFor();
}

async function press(page, name) {
  const button = page.getByRole("button", { name, exact: true });
  await button.focus();
  await page.keyboard.press("Enter");
}

async function goTo(page, view) {
  await page.locator(".steps a", { hasText: view }).focus();
  await page.keyboard.press("Enter");
}

/** The instructor sets up a rig, makes a class, and saves the keys of its students. */
async function handOutKeys(page) {
  await page.goto(`${address}/#rig`);
  await signIn(page, KEY, "Lecturer");
  await page.getByRole("heading", { name: "chapter-5-beam" }).waitFor();
  await fill(page, "Lines", 201);
  await fill(page, "Averages", 10);
  await goTo(page, "Class");
  await page.getByRole("heading", { name: "No class yet" }).waitFor();
  await fill(page, "Name of the class", "Dynamics");
  await tabTo(page, "button.wide:not(:disabled)");
  await page.keyboard.press("Enter");
  await page.keyboard.press("Enter"); // the hand was too quick: one class is made all the same
  await page.getByRole("heading", { name: "Dynamics" }).waitFor();
  const names = page.getByLabel("Names, one a line");
  await names.focus();
  await page.keyboard.type(STUDENTS.join("\n"));
  const saved = page.waitForEvent("download");
  await press(page, "Make 3 keys");
  const table = readFileSync(await (await saved).path(), "utf8").trim().split(/\r?\n/).map((line) => line.split(","));
  assert(table[0].join() === "name,id,key" && table.length === 4, "the file has a key for each name");
  for (const [name, , key] of table.slice(1)) keys[name] = key;
  const shown = await page.evaluate(() => JSON.stringify([document.body.innerHTML, { ...localStorage }, { ...sessionStorage }]));
  assert(!Object.values(keys).some((key) => shown.includes(key)), "the keys are in the file alone");
  const { items } = await page.evaluate(async () => (await fetch("/v1/classes")).json());
  assert(items.length === 1, "there is one class");
  await handOutLinks(page);
}

async function handOutLinks(page) {
  const saved = page.waitForEvent("download");
  await press(page, "Make a link for each student");
  const [head, ...rows] = readFileSync(await (await saved).path(), "utf8").trim().split("\n").map((line) => line.split(","));
  assert(head.join() === "name,link" && rows.map(([name]) => name).join() === STUDENTS.join(), `a link for each student: ${rows}`);
  for (const [name, link] of rows) links[name] = link;
  assert(rows.every(([, link]) => link.startsWith(`${address}/#once=`)), "the secret is behind #");
  const shown = await page.evaluate(() => document.body.innerHTML);
  assert(!rows.some(([, link]) => shown.includes(link.split("=")[1])), "the links are in the file alone");
}

async function handOutAssignment(page) {
  await page.getByText("New assignment").waitFor();
  await fill(page, "One of the points", "9:+Y");
  await fill(page, "mass from", 0.045);
  await fill(page, "mass to", 0.055);
  await fill(page, "Tests of each student", 2);
  await fill(page, "Points for words", 3);
  await page.getByLabel("Diagnosis", { exact: true }).selectOption("on");
  await page.getByLabel("Deadline", { exact: true }).fill("2099-12-31T18:00");
  await examine(page, "class-form", folder);
  await press(page, "Hand out the assignment");
  await page.locator('[aria-label="Table of marks"] tbody tr').nth(2).waitFor();
  await page.getByText("0 of 3 have measured, 0 have submitted.").waitFor();
  await reload(page, () => page.getByRole("button", { name: "Sign out" }).click());
}

/** A student signs in, measures within the choices, extracts modes, answers, and reads the marks. */
async function student(page, index, answer) {
  await page.getByRole("dialog", { name: "Sign in" }).waitFor();
  await signIn(page, keys[STUDENTS[index]], STUDENTS[index]);
  await goTo(page, "Class");
  await page.getByText("2 of 2 tests left, 1 of 1 answers left.").waitFor();
  const told = await (await page.request.get(`${address}/v1/assignments`)).text();
  assert(told.includes("quota") && !told.includes("extra_mass"), "nothing tells what is hidden");
  await fill(page, "Averages", 500);
  assert((await page.locator(".wrong").innerText()) === "a whole number from 5 to 100", "the limits of a choice are told");
  await fill(page, "Averages", 20);
  await press(page, "Measure");
  await page.getByText("1 of 2 tests left").waitFor();
  await press(page, "Saved work");
  const saved = page.getByRole("dialog").getByRole("list", { name: "Tests" });
  await saved.waitFor();
  assert((await saved.locator("li").count()) === 1, "one's own tests are listed, no others");
  await press(page, "Close");
  await page.getByRole("link", { name: "Extract modes, test 1" }).click();
  await press(page, "Extract");
  await page.locator('[aria-label="Table of modes"] tbody tr').first().waitFor();
  await answer(page);
  await press(page, "Submit, the last answer");
  const marks = page.locator(".marks");
  await marks.waitFor();
  if (index === 1) await examine(page, "class-student", folder);
  const result = {
    python: await page.locator(".panel [data-python]").getAttribute("data-python"),
    points: await marks.locator("h2").innerText(),
    reasons: await marks.locator("dd").allInnerTexts(),
  };
  await reload(page, () => page.getByRole("button", { name: "Sign out" }).click());
  return result;
}

/** Let the diagnosis find the answer, and take it over. */
async function byDiagnosis(page) {
  await goTo(page, "Diagnose");
  await page.locator("button.primary").first().click();
  await page.locator(".verdict").waitFor({ timeout: 300_000 }); // alone it takes five seconds
  await goTo(page, "Class");
  await press(page, "Take over what the diagnosis found");
}

async function byHand(page, kind, place) {
  await goTo(page, "Class");
  await page.getByLabel("Effect", { exact: true }).selectOption(kind);
  await press(page, "Add the effect");
  await fill(page, "Point", place);
}

/** The instructor sees who has submitted, and saves the marks. */
async function seeMarks(page) {
  await page.getByRole("dialog", { name: "Sign in" }).waitFor();
  await signIn(page, KEY, "Lecturer");
  await goTo(page, "Class");
  await page.getByText("3 of 3 have measured, 3 have submitted.").waitFor();
  await page.getByText("3 of 3 without points.").waitFor();
  await page.getByLabel("Points, of 3", { exact: true }).first().fill("2");
  await page.getByLabel("Comment").first().fill("Right, but short.");
  await page.getByRole("button", { name: "Give the points" }).first().press("Enter");
  await page.getByText("2 of 3 without points.").waitFor();
  const saved = page.waitForEvent("download");
  await page.getByRole("button", { name: "Marks, CSV" }).click();
  const table = readFileSync(await (await saved).path(), "utf8").trim().split(/\r?\n/);
  await examine(page, "class-marks", folder);
  const python = await page.locator(".watched [data-python]").getAttribute("data-python");
  const rows = await page.locator('[aria-label="Table of marks"] tbody tr').allInnerTexts();
  await reload(page, () => page.getByRole("button", { name: "Sign out" }).click());
  return { rows, table, python };
}

/** A link signs its student in once, in a window that shows the page and in a new one. */
async function useLink(page) {
  const [name] = STUDENTS;
  const asked = [];
  const note = (request) => asked.push(request.url());
  page.on("request", note);
  await page.getByRole("dialog", { name: "Sign in" }).waitFor();
  await page.goto(links[name]); // another fragment of the same address: the page is not loaded again
  await page.locator(".account-name", { hasText: name }).waitFor();
  const secret = links[name].split("=")[1];
  assert(!page.url().includes(secret) && !asked.some((url) => url.includes(secret)), "the secret is in no address");
  await page.goBack();
  assert(!page.url().includes(secret), "no step back leads to the secret");
  await page.goto(`${address}/`);
  await page.locator(".account-name", { hasText: name }).waitFor();
  await reload(page, () => page.getByRole("button", { name: "Sign out" }).click());
  await page.getByRole("dialog", { name: "Sign in" }).waitFor();
  await page.goto("about:blank");
  await page.goto(links[name]);
  const told = await page.getByRole("dialog", { name: "Sign in" }).getByRole("alert").innerText();
  await examine(page, "used-link", folder);
  page.off("request", note);
  return { told };
}
