/**
 * What a newcomer does first on the page, with the mouse: open it, measure, extract, diagnose.
 *
 * Usage: node e2e/newcomer.mjs ADDRESS [FOLDER], on a service without keys. Prints the seconds of each step as JSON.
 */

import { assert, drawn } from "./checks.mjs";
import { walk } from "./steps.mjs";

const [address, folder] = process.argv.slice(2);

await walk(address, folder, [["open", open], ["measure", measure], ["extract", extract], ["diagnose", diagnose]]);

async function open(page) {
  await page.goto(`${address}/`);
  await page.getByRole("heading", { name: "chapter-5-beam" }).waitFor();
  await page.locator(".switch", { hasText: "extra mass" }).click(); // something to be found
}

async function measure(page) {
  await page.locator("a.next").click();
  await page.getByRole("button", { name: "Start the test" }).click();
  await page.locator(".chart canvas").first().waitFor();
  await drawn(page);
}

async function extract(page) {
  await page.locator("a.next").first().click();
  await page.getByRole("button", { name: "Extract", exact: true }).click();
  const rows = page.locator('[aria-label="Table of modes"] tbody tr');
  await rows.first().waitFor();
  return { modes: await rows.count() };
}

async function diagnose(page) {
  await page.getByRole("link", { name: "Diagnose", exact: true }).last().click();
  await page.getByRole("button", { name: "Start the diagnosis" }).first().click();
  await page.locator(".verdict").waitFor({ timeout: 300_000 }); // alone it takes some seconds
  const verdict = await page.locator(".verdict").innerText();
  assert(verdict.includes("extra mass"), verdict);
  return { verdict };
}
