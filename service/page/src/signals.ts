/** What FRFs are made of: the time record of a force and a response, and their auto spectra. */

import { column } from "./frf";
import type { Arrays } from "./npz";
import { thin } from "./thin";

export interface Trace {
  x: number[];
  y: number[];
}

const COLUMNS = 600; // of a figure

/** Return what a figure shows of a curve, every peak in it. */
function thinned(x: Float64Array, y: Float64Array): Trace {
  const kept = thin(x, y, x[0], x[x.length - 1], COLUMNS);
  return { x: kept.map((i) => x[i]), y: kept.map((i) => y[i]) };
}

/** Return the first record of the force and of a response over time, s; null where that is not recorded. */
export function recordsOf(arrays: Arrays, response: string): { force: Trace; response: Trace } | null {
  const outputs = arrays.outputs.values as string[];
  const [, samples, runs, width] = arrays.response.shape;
  const at = outputs.indexOf(response); // (n_runs, n_responses)
  if (at < 0) return null;
  const run = Math.floor(at / width);
  const rate = (arrays.sample_rate.values as Float64Array)[0];
  const time = Float64Array.from({ length: samples }, (_, i) => i / rate);
  const channel = (name: string, index: number) => {
    const { values, shape } = arrays[name];
    return time.map((_, i) => (values as Float64Array)[(i * runs + run) * shape[3] + index]);
  };
  return { force: thinned(time, channel("force", 0)), response: thinned(time, channel("response", at % width)) };
}

/** Return the auto spectra of the force and of a response, dB; null where a test has none. */
export function spectraOf(arrays: Arrays, response: string): { force: Trace; response: Trace } | null {
  const { force_spectrum: force, response_spectrum: answer } = arrays;
  const row = (arrays.outputs.values as string[]).indexOf(response);
  if (!force?.values.length || !answer?.values.length || row < 0) return null;
  const freq = arrays.freq.values as Float64Array;
  const inputs = arrays.inputs.values.length;
  // The line at 0 Hz has no acceleration: its level would be minus infinity.
  const level = (name: string, index: number) => column(arrays, name, index)[0].map((value) => (value > 0 ? 10 * Math.log10(value) : Number.NaN)).subarray(1);
  const shown = (name: string, index: number) => {
    const y = level(name, index);
    const known = y.map((value, i) => (Number.isNaN(value) ? Number.NaN : i)).filter((i) => !Number.isNaN(i));
    return thinned(Float64Array.from(known, (i) => freq[i + 1]), Float64Array.from(known, (i) => y[i]));
  };
  return { force: shown("force_spectrum", row * inputs), response: shown("response_spectrum", answer.shape.length === 3 ? row * inputs : row) };
}
