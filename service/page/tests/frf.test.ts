import { expect, test } from "vitest";
import { nearest, sameLines } from "../src/frf";

const coarse = Float64Array.from([0, 2, 4, 6]);

test("a curve is read at the nearest of its own lines, and nowhere beyond them", () => {
  const read = nearest(coarse, Float64Array.from([1, 2, 3, 4]), Float64Array.from([0, 0.9, 1.5, 4, 5.5, 6, 7]));
  expect([...read]).toEqual([1, 1, 2, 3, 4, 4, Number.NaN]);
});

test("tests have the same lines only if number and ends agree", () => {
  expect(sameLines(coarse, coarse.slice())).toBe(true);
  expect(sameLines(coarse, Float64Array.from([0, 3, 6]))).toBe(false);
  expect(sameLines(coarse, Float64Array.from([0, 2, 4, 7]))).toBe(false);
});
