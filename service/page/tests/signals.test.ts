import { expect, test } from "vitest";
import type { Arrays, NumpyArray } from "../src/npz";
import { recordsOf, spectraOf } from "../src/signals";

const numbers = (shape: number[], values: number[]): NumpyArray => ({ shape, values: Float64Array.from(values), complex: false });
const texts = (shape: number[], values: string[]): NumpyArray => ({ shape, values, complex: false });

// two records of three samples, two runs of one force and one response
const RECORDS: Arrays = {
  force: numbers([2, 3, 2, 1], [1, 10, 2, 20, 3, 30, 0, 0, 0, 0, 0, 0]),
  response: numbers([2, 3, 2, 1], [4, 40, 5, 50, 6, 60, 0, 0, 0, 0, 0, 0]),
  sample_rate: numbers([], [100]),
  outputs: texts([2, 1], ["1:+Y", "2:+Y"]),
};

test("a record is the first one of the run that has the response", () => {
  const { force, response } = recordsOf(RECORDS, "2:+Y")!;
  expect(force).toEqual({ x: [0, 0.01, 0.02], y: [10, 20, 30] });
  expect(response.y).toEqual([40, 50, 60]);
  expect(recordsOf(RECORDS, "3:+Y")).toBeNull();
});

test("spectra are levels, without the line at 0 Hz and without lines of no power", () => {
  const arrays: Arrays = {
    freq: numbers([4], [0, 1, 2, 3]),
    outputs: texts([2], ["1:+Y", "2:+Y"]),
    inputs: texts([1], ["1:+Y"]),
    force_spectrum: numbers([4, 2, 1], [9, 9, 1, 10, 1, 0, 1, 1000]),
    response_spectrum: numbers([4, 2], [0, 0, 1, 100, 1, 0.1, 1, 1]),
  };
  const { force, response } = spectraOf(arrays, "2:+Y")!;
  expect(force.x).toEqual([1, 3]);
  expect(force.y.map(Math.round)).toEqual([10, 30]);
  expect(response.y.map(Math.round)).toEqual([20, -10, 0]);
  expect(spectraOf({ ...arrays, force_spectrum: numbers([0], []) }, "2:+Y")).toBeNull();
});
