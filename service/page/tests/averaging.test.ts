import { expect, test } from "vitest";
import { estimatesOf, keptEstimates, keptRecords, meaningOf } from "../src/averaging";
import type { Frfs } from "../src/frf";
import type { Arrays, NumpyArray } from "../src/npz";
import { type RigDraft, USUAL } from "../src/rig";

const texts = (values: string[]): NumpyArray => ({ shape: [values.length], values, complex: false });

// two estimates of two lines and two responses, in single precision as they come
const ARRAYS: Arrays = {
  n_averages: { shape: [2], values: Float64Array.from([1, 30]), complex: false },
  freq: { shape: [2], values: Float64Array.from([0, 1]), complex: false },
  values: { shape: [2, 2, 2, 1], values: Float32Array.from({ length: 16 }, (_, i) => i), complex: true },
  coherence: { shape: [2, 2, 2], values: Float32Array.from([1, 1, 1, 1, 0.5, 0.25, 0.75, 0.125]), complex: false },
  outputs: texts(["1:+Y", "2:+Y"]),
  inputs: texts(["1:+Y"]),
  kind: texts(["inertance"]),
};
const TEST: Frfs = { freq: Float64Array.from([0, 1]), kind: "inertance", curves: [] };

test("an estimate has the FRFs and the coherence of its averages, on the lines of the test", () => {
  const [{ count, frfs }] = estimatesOf(ARRAYS, TEST);
  expect(count).toBe(1);
  expect(frfs.freq).toBe(TEST.freq);
  expect(frfs.curves.map(({ output }) => output)).toEqual(["1:+Y", "2:+Y"]);
  expect([...frfs.curves[1].real]).toEqual([2, 6]);
  expect([...frfs.curves[1].imaginary]).toEqual([3, 7]);
  expect([...frfs.curves[1].coherence!]).toEqual([1, 1]);
});

test("the last estimate is the test itself", () => {
  const estimates = estimatesOf(ARRAYS, TEST);
  expect(estimates).toHaveLength(2);
  expect(estimates[1]).toEqual({ count: 30, frfs: TEST });
  expect(estimates[1].frfs).toBe(TEST);
});

const rigOf = (change: Partial<RigDraft>, responses = 11): RigDraft => ({
  ...USUAL,
  drive: "1:+Y",
  frequencyMax: 800,
  responses: Array.from({ length: responses }, (_, i) => `${i + 1}:+Y`),
  ...change,
});

test("a usual test keeps ten estimates, a short one an estimate after each average", () => {
  expect(keptEstimates(rigOf({}))).toBe(10);
  expect(keptEstimates(rigOf({ nLines: 401, averages: 12 }))).toBe(12);
  expect(keptEstimates(rigOf({ nLines: 101, averages: 100 }, 2))).toBe(24);
});

test("a test that is large as it is keeps none, and one average has nothing before it", () => {
  expect(keptEstimates(rigOf({ nLines: 6401 }, 24))).toBe(0);
  expect(keptEstimates(rigOf({ averages: 1 }))).toBe(0);
  expect(keptRecords(rigOf({}))).toBe(1);
  expect(keptRecords(rigOf({ nLines: 100_001 }))).toBe(0);
});

test("with as many averages as forces coherence tells nothing", () => {
  expect(meaningOf(1, 1)).toBe("After one average coherence is 1 by definition, whatever the noise.");
  expect(meaningOf(2, 2)).toMatch(/^With as many averages as forces coherence is 1/);
  expect(meaningOf(4, 1)).toBe("Their random error is 50 % of that of one; noise alone still has a coherence of about 0.3.");
});
