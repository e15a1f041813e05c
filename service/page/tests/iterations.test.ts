import { expect, test } from "vitest";
import { seriesOf } from "../src/views/iterations";

const macro = (part: string, ...members: number[]) => ({ part, members });

test("a coefficient goes from 1 through its iterations; what is suspected lies on top", () => {
  const history = [
    { stage: "location", macros: [macro("mass", 9), macro("stiffness", 9), macro("mass", 1, 2)], coefficients: [1.4, 2, 0.9] },
    { stage: "updating", macros: [macro("mass", 9)], coefficients: [1.5] },
  ];
  expect(seriesOf(history, "mass", [9])).toEqual([
    { label: "others", x: [0, 1], y: [1, 0.9], mark: "line", tone: "faint" },
    { label: "member 9", x: [0, 1, 2], y: [1, 1.4, 1.5], mark: "line", tone: "warm" },
  ]);
  expect(seriesOf(history, "damping", [9])).toEqual([]);
});
