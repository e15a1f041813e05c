/** Averages of a test as they build up, after each of twelve. */

import { assert, drawn, examine, tabTo } from "./checks.mjs";

/** Note the numbers of averages that are shown from now on; motion is welcome. */
export async function noteAverages(page) {
  await page.emulateMedia({ reducedMotion: "no-preference" });
  await page.evaluate(() => {
    globalThis.counts = [];
    const note = () => {
      const count = document.querySelector(".averaging b")?.textContent;
      if (count && count !== globalThis.counts.at(-1)) globalThis.counts.push(count);
    };
    new MutationObserver(note).observe(document.body, { subtree: true, childList: true, characterData: true });
  });
}

/** The averages have built up by themselves; by the keyboard they do so again, forth and back. */
export async function averageByAverage(page, folder) {
  const count = (n) => page.locator(".averaging b", { hasText: new RegExp(`^${n}$`) }).waitFor();
  const button = (name) => page.locator(".averaging button", { hasText: name });
  await button("Play").waitFor();
  const played = await page.evaluate(() => globalThis.counts.join());
  assert(played === "1,2,3,4,5,6,7,8,9,10,11,12", `the averages build up one by one, not ${played}`);
  await tabTo(page, ".averaging button");
  await page.keyboard.press("Enter");
  await button("Pause").waitFor();
  await tabTo(page, ".averaging input");
  await page.keyboard.press("Home"); // and so it pauses
  await count(1);
  await button("Play").waitFor();
  const spoken = () => page.getByRole("slider", { name: "Averages" }).getAttribute("aria-valuetext");
  assert((await spoken()) === "1 of 12 averages", `the slider says ${await spoken()}`);
  assert((await page.locator(".averaging .hint").innerText()).includes("coherence is 1 by definition"), "one average tells no coherence");
  const noisy = await ink(page);
  await examine(page, "averaging", folder);
  await page.locator(".averaging input").focus();
  await page.keyboard.press("ArrowRight");
  await count(2);
  await page.keyboard.press("End");
  await count(12);
  await drawn(page);
  const settled = await ink(page);
  assert(noisy > 0.7 * settled, `curves after one average are in sight, not ${noisy} pixels of ${settled}`);
}

/** Return the pixels of the first plot that something is drawn on. */
const ink = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector(".chart canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((value, i) => i % 4 === 3 && value > 128).length;
  });
