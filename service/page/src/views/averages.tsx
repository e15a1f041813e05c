/** Averages of a test while they are taken: how many there are, and what they leave of the random error. */

import { short } from "../format";

export interface Averages {
  run: number;
  runs: number;
  count: number;
  of: number;
}

/** Return the averages that the progress of a test tells of; null before the first, and of other work. */
export function averagesIn(message: string | undefined): Averages | null {
  const found = /^run (\d+) of (\d+), average (\d+) of (\d+)$/.exec(message ?? "");
  if (!found) return null;
  const [run, runs, count, of] = found.slice(1).map(Number);
  return { run, runs, count, of };
}

const MOST_CELLS = 60;

export function AveragesNote({ message }: { message: string | undefined }) {
  const averages = averagesIn(message);
  if (!averages) return null;
  const { run, runs, count, of } = averages;
  const cells = Math.min(of, MOST_CELLS);
  const filled = Math.floor((cells * count) / of);
  return (
    <div class="averages">
      <p class="averages-words">
        <b>{count}</b> of {of} averages{runs > 1 ? `, run ${run} of ${runs}` : ""}
        <span class="hint">Their random error is {short(100 / Math.sqrt(count), 2)} % of that of one.</span>
      </p>
      <div class="averages-cells" aria-hidden="true">{Array.from({ length: cells }, (_, i) => <i class={i < filled ? "taken" : ""} />)}</div>
    </div>
  );
}
