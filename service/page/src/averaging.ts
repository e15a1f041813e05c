/** FRFs and coherence of a test while its averages were taken. */

import { short } from "./format";
import { type Frfs, frfsOf } from "./frf";
import type { Arrays, NumpyArray } from "./npz";
import type { RigDraft } from "./rig";

export interface Estimate {
  /** Averages taken. */
  count: number;
  frfs: Frfs;
}

/** Return the estimates of a test in the order they were taken; the last is the test itself. */
export function estimatesOf(arrays: Arrays, test: Frfs): Estimate[] {
  const counts = Array.from(arrays.n_averages.values as Float64Array);
  const { values, coherence } = arrays;
  return counts.map((count, i) => {
    if (i === counts.length - 1) return { count, frfs: test };
    // On the very lines of the test: what a plot need not draw anew.
    return { count, frfs: { ...frfsOf({ ...arrays, values: row(values, i), coherence: row(coherence, i) }), freq: test.freq } };
  });
}

/** Return entry `i` along the first axis. */
function row(array: NumpyArray, i: number): NumpyArray {
  const shape = array.shape.slice(1);
  const size = shape.reduce((product, n) => product * n, array.complex ? 2 : 1);
  return { ...array, shape, values: (array.values as Float64Array).subarray(i * size, (i + 1) * size) };
}

const MOST_SAMPLES = 2 ** 20; // of all channels of a record, half of what a test may keep
const SAMPLES_A_LINE = 3; // and less
const LIGHT = 1_600_000; // bytes of a test, above which the service needs a process for each question about it
const OF_A_TEST = 40; // bytes for a line of an FRF: FRF, coherence, two auto spectra
const OF_AN_ESTIMATE = 12; // in single precision: FRF and coherence
const MOST = 24; // steps that the eye tells apart

/** Return how many time records a test keeps for the page: one, unless it is very large. */
export const keptRecords = (rig: RigDraft): number => (samplesOf(rig) <= MOST_SAMPLES ? 1 : 0);

/** Return how many estimates a test keeps for the page: as many as leave it light. */
export function keptEstimates(rig: RigDraft): number {
  const values = rig.nLines * rig.responses.length;
  const room = LIGHT - OF_A_TEST * values - 8 * keptRecords(rig) * samplesOf(rig);
  const kept = Math.min(MOST, rig.averages, 1 + Math.floor(room / (OF_AN_ESTIMATE * values)));
  return kept > 1 ? kept : 0;
}

const samplesOf = (rig: RigDraft): number => SAMPLES_A_LINE * rig.nLines * (rig.responses.length + 1);

/** Return what a number of averages means for what is seen. */
export function meaningOf(count: number, forces: number): string {
  if (count <= forces) return `${count === 1 ? "After one average" : "With as many averages as forces"} coherence is 1 by definition, whatever the noise.`;
  return `Their random error is ${short(100 / Math.sqrt(count), 2)} % of that of one; noise alone still has a coherence of about ${short(forces / count, 1)}.`;
}
