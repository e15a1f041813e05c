/**
 * A student's way in and out of a service with keys: a wrong key, the right one, a test, an expired session, out.
 *
 * Usage: KEY=... node e2e/sign-in.mjs ADDRESS [FOLDER]. Prints what was checked as JSON, a line each.
 */

import { assert, examine, fill, reload } from "./checks.mjs";
import { walk } from "./steps.mjs";

const [address, folder] = process.argv.slice(2);
const { KEY } = process.env; // not an argument: those are seen by every user of the machine
const COOKIE = "modallab_session";

const form = (page) => page.getByRole("dialog", { name: "Sign in" });
const account = (page) => page.locator(".account");
const sessionCookie = async (page) => (await page.context().cookies(`${address}/v1/`)).find((cookie) => cookie.name === COOKIE);

const seen = []; // written to the console, of every level, and addresses
await walk(address, folder, STEPS(), {
  tolerated: "401", // the browser writes refusals
  secret: KEY,
  before: (page) => {
    page.on("console", (message) => seen.push(message.text()));
    page.on("request", (request) => seen.push(request.url()));
  },
  after: keptSecret,
});

function STEPS() {
  return [
    ["wrong key", wrongKey],
    ["student's key", rightKey],
    ["measure", measure],
    ["expired session", expired],
    ["sign out", signOut],
  ];
}

/** The key is in no address, no message, no storage, no cookie that a script reads, and nowhere in the page. */
async function keptSecret(page) {
  const kept = await page.evaluate(() => JSON.stringify([location.href, { ...localStorage }, { ...sessionStorage }, document.cookie, document.body.innerHTML]));
  assert(![...seen, kept].some((text) => text.includes(KEY)), "the key has been kept");
}

async function signInWith(page, key) {
  await page.getByLabel("Key", { exact: true }).fill(key);
  await page.keyboard.press("Enter");
}

async function wrongKey(page) {
  await page.goto(`${address}/`);
  await form(page).waitFor();
  assert(await page.evaluate(() => document.activeElement.id === "key"), "the field has the focus");
  assert((await account(page).count()) === 0, "nobody is signed in");
  await signInWith(page, "modallab_wrong");
  const told = await form(page).getByRole("alert").innerText();
  await examine(page, "sign-in", folder);
  await page.keyboard.press("Escape");
  await page.getByText("Sign in at the top of the page").waitFor();
  await page.getByRole("button", { name: "Sign in" }).click();
  await form(page).waitFor();
  return { told };
}

async function rightKey(page) {
  await signInWith(page, KEY);
  await account(page).waitFor();
  assert((await form(page).count()) === 0, "the form has closed");
  const cookie = await sessionCookie(page);
  assert(cookie.httpOnly && cookie.sameSite === "Strict", JSON.stringify({ ...cookie, value: "" }));
  await page.getByRole("button", { name: "Try again" }).click();
  await page.getByRole("heading", { name: "chapter-5-beam" }).waitFor();
  await account(page).waitFor(); // the page has been loaded again, the session has stayed
  return { who: await account(page).innerText() };
}

async function measure(page) {
  await fill(page, "Lines", 101);
  await fill(page, "Averages", 3);
  await page.locator("a.next").click();
  await page.getByRole("button", { name: "Start the test" }).click();
  await page.locator(".chart canvas").first().waitFor();
  const python = await page.getByRole("button", { name: "Copy as Python" }).getAttribute("data-python");
  await examine(page, "signed-in", folder);
  return { python };
}

async function expired(page) {
  await fill(page, "Seed of the noise", 77);
  await page.context().clearCookies();
  await page.getByRole("button", { name: "Measure again" }).click();
  await form(page).waitFor();
  const before = page.url();
  await signInWith(page, KEY);
  await page.waitForFunction((url) => location.href !== url, before); // the refused test has run
  assert((await page.getByLabel("Seed of the noise").inputValue()) === "78", "the form has been kept");
}

async function signOut(page) {
  await reload(page, () => page.getByRole("button", { name: "Sign out" }).click());
  await form(page).waitFor();
  assert((await sessionCookie(page)) === undefined, "the cookie is gone");
  assert(!page.url().includes("t="), "the next person does not see whose tests were shown");
  const reply = await page.request.get(`${address}/v1/sessions`);
  assert(reply.status() === 401, `the session has ended: ${reply.status()}`);
}
