import { expect, test } from "vitest";
import { averagesIn } from "../src/views/averages";

test("the progress of a test tells its averages", () => {
  expect(averagesIn("run 2 of 3, average 12 of 30")).toEqual({ run: 2, runs: 3, count: 12, of: 30 });
});

test("other work tells none", () => {
  expect(averagesIn("measured")).toBeNull();
  expect(averagesIn(undefined)).toBeNull();
});
