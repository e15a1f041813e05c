/**
 * What a diagnosis offers beyond its verdict: an effect of no catalogue is adopted, a proposed test is run.
 *
 * Usage: node e2e/explain.mjs ADDRESS [FOLDER], on a service without keys. Prints what was checked as JSON.
 */

import { assert, examine, tabTo } from "./checks.mjs";
import { walk } from "./steps.mjs";

const [address, folder] = process.argv.slice(2);

const BEAM = {
  kind: "beam", length: 1.2, n_elements: 8,
  section: { area: 5e-4, second_moment: 4.1667e-9 },
  material: { modulus: 2.09e11, density: 7800 },
  damping: { law: "structural", stiffness_coefficient: 0.008 },
};
const OSCILLATOR = { kind: "attached_oscillator", at: "5:+Y", parameters: { mass: 0.05, frequency: 120 } };
const MASS = { kind: "accelerometer_mass", at: null, parameters: { mass: 0.02 } };

await walk(address, folder, [["unknown effect", unknownEffect], ["next test", nextTest]]);

async function post(page, path, data) {
  const reply = await page.request.post(`${address}/v1${path}`, { data });
  assert(reply.ok(), await reply.text());
  return reply.json();
}

async function result(page, path, data) {
  let job = await post(page, path, data);
  while (["queued", "running"].includes(job.state)) {
    await page.waitForTimeout(200);
    job = await (await page.request.get(`${address}/v1/jobs/${job.id}`)).json();
  }
  return job.result_id;
}

/** Make a test with a hidden effect and open its diagnosis. */
async function openDiagnosis(page, rig, effect, options = {}) {
  const model = (await post(page, "/structures", BEAM)).id;
  const declared = (await post(page, "/rigs", { drive: "1:+Y", ...rig })).id;
  const test = await result(page, "/measurements", { structure_id: model, rig_id: declared, effects: [effect], route: "drawn", seed: 1 });
  const found = await result(page, "/diagnoses", { structure_id: model, measurement_id: test, ...options });
  await page.goto(`${address}/#diagnose?s=${model}&d=${found}&t=${test}`);
  await page.locator(".verdict").waitFor();
}

/** A force that no suspect explains has a curve and a law; adopted, it explains FRFs that were kept out. */
async function unknownEffect(page) {
  const rig = {
    responses: ["1:+Y", "2:+Y", "4:+Y", "5:+Y", "7:+Y", "9:+Y"],
    noise: { force: 1e-3, response: 1e-3 },
    analyser: { frequency_max: 400, n_lines: 161 },
  };
  await openDiagnosis(page, rig, OSCILLATOR, { suspects: ["polarity"] });
  const law = await page.locator(".unknown > p").first().innerText();
  const gaps = () => page.locator(".unknown .gap dd").allInnerTexts();
  const before = Number((await gaps())[1]);
  await examine(page, "unknown", folder);
  await page.getByRole("button", { name: "Adopt it" }).focus();
  await page.keyboard.press("Enter");
  await page.getByText("Adopted as a tabulated stiffness").waitFor();
  const after = Number((await gaps())[1].split("→")[1]);
  assert(before > 100 && after < 2, `the gap of the FRFs kept out goes from ${before} to ${after}`);
  await examine(page, "adopted", folder);
  await tabTo(page, ".unknown .notice button");
  await page.keyboard.press("Enter");
  await page.locator(".verdict.nothing_missing").waitFor();
  return { law, before, after };
}

/** What one FRF cannot tell apart is told apart by the test that is proposed. */
async function nextTest(page) {
  const rig = { responses: ["1:+Y"], noise: { force: 3e-3, response: 3e-3 }, analyser: { frequency_max: 200, n_lines: 101, averages: 10 } };
  await openDiagnosis(page, rig, MASS);
  const rivals = await page.locator('[aria-label="Table of rivals"] tbody tr').allInnerTexts();
  await page.getByRole("button", { name: "Run it and diagnose again" }).focus();
  const begin = Date.now();
  await page.keyboard.press("Enter");
  await page.getByText("Explained together with a test with exciter hammer").waitFor({ timeout: 300_000 }); // alone it takes some seconds
  const seconds = (Date.now() - begin) / 1000;
  const alike = await page.locator(".steps-found .hint").allInnerTexts();
  assert(rivals.length === 4 && !alike.join().includes("force transducer mass"), `the hammer has told them apart: ${alike}`);
  await examine(page, "next-test", folder);
  return { alike, seconds };
}
