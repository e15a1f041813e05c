import { expect, test } from "vitest";
import { logTicks } from "../src/plot/log-ticks";

test("an axis that begins little below a power of ten has ticks, and an end", () => {
  expect(logTicks(0.0096, 0.035)).toEqual([0.01, 0.02, 0.03]);
});

test("ticks are one to nine times each power of ten inside", () => {
  expect(logTicks(7, 25)).toEqual([7, 8, 9, 10, 20]);
  expect(logTicks(0.1, 1)).toHaveLength(10);
});

test("an interval that is none has no ticks", () => {
  expect(logTicks(0, 1)).toEqual([]);
  expect(logTicks(1, Number.NaN)).toEqual([]);
});
