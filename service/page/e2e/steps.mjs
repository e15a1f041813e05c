/** A way through the page, step by step. */

import { withBrowser } from "./browser.mjs";
import { DESK, assert, picture } from "./checks.mjs";

/**
 * Walk through `steps`, pairs of a name and a function of page and faults that returns figures. Prints of each what
 * was found and the seconds that it took, as JSON, a line each; the first fault ends the way, for what follows
 * builds on it. `tolerated` is part of a complaint of the browser that is none; `after(page)` checks each step, and
 * `secret` is left out of what is printed. Pictures go to `folder`, if there is one.
 */
export async function walk(address, folder, steps, { tolerated = null, secret = null, before, after } = {}) {
  const failed = await withBrowser(address, { viewport: DESK, acceptDownloads: true }, async (context, faults) => {
    const page = await context.newPage();
    await before?.(page);
    for (const [name, step] of steps) {
      const begin = Date.now();
      try {
        const figures = await step(page, faults);
        const unexpected = faults.splice(0).filter((fault) => tolerated === null || !fault.includes(tolerated));
        assert(unexpected.length === 0, unexpected.join("; "));
        await after?.(page);
        console.log(JSON.stringify({ name, seconds: (Date.now() - begin) / 1000, ...figures }));
      } catch (error) {
        await picture(page, "failed", folder);
        console.log(JSON.stringify({ name, fault: secret ? error.message.replaceAll(secret, "KEY") : error.message }));
        return true;
      }
    }
    return false;
  });
  process.exitCode = failed ? 1 : 0;
}
