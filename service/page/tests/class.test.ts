import { expect, test } from "vitest";
import { type Assignment, firstOf, hiddenOf, isOver, namesOf, placeOf, placeText, trialOf, valueAt } from "../src/class";
import { HIDDEN_ROWS } from "../src/hidden";

const row = (kind: string) => HIDDEN_ROWS.find((one) => one.kind === kind)!;

test("names are one a line, each once", () => {
  expect(namesOf(" A \n\nB\nA\r\n")).toEqual(["A", "B"]);
});

test("a hidden effect is drawn from places and limits; what is not drawn stands alone", () => {
  const mass = { row: row("extra_mass"), places: "3:+Y, 7:+Y", limits: { mass: [0.02, 0.08] as [number, number] } };
  expect(hiddenOf(mass, "1:+Y")).toEqual({ kind: "extra_mass", at: { one_of: ["3:+Y", "7:+Y"] }, parameters: { mass: { between: [0.02, 0.08] } } });
  const stiff = { row: row("stiffness_error"), places: "7", limits: { factor: [1.3, 1.3] as [number, number] } };
  expect(hiddenOf(stiff, "1:+Y")).toEqual({ kind: "stiffness_error", at: { members: [7] }, parameters: { factor: 1.3 } });
  const stinger = { row: row("stinger_axial"), places: "9:+Y", limits: {} };
  expect(hiddenOf(stinger, "1:+Y").at).toBe("1:+Y");
  expect(hiddenOf({ ...stinger, row: row("leakage") }, "1:+Y").at).toBe(null);
});

test("places are read as they are written", () => {
  for (const at of ["5:+Y", { members: [3, 4] }, { channels: ["5:+Y", "7:+Y"] }, null]) {
    expect(placeOf(...placeText(at))).toEqual(at);
  }
});

test("chosen fields stand where the rig has them, the route beside it", () => {
  const chosen = { drive: "9:+Y", "analyser.averages": 20, "analyser.window": "hann", route: "drawn" };
  expect(trialOf(chosen)).toEqual({ rig: { drive: "9:+Y", analyser: { averages: 20, window: "hann" } }, route: "drawn" });
});

test("a choice begins with what the rig has, where that is allowed", () => {
  const rig = { drive: "1:+Y", analyser: { averages: 200 }, responses: ["1:+Y", "2:+Y"] };
  expect(firstOf({ between: [5, 100] }, valueAt(rig, "analyser.averages"))).toBe(100);
  expect(firstOf({ between: [5, 100] }, valueAt(rig, "analyser.overlap"))).toBe(5);
  expect(firstOf({ one_of: ["3:+Y", "5:+Y"] }, valueAt(rig, "drive"))).toBe("3:+Y");
  expect(firstOf({ one_of: ["2:+Y", "3:+Y"] }, valueAt(rig, "responses"))).toEqual(["2:+Y"]);
});

test("an assignment ends with its deadline", () => {
  const until = (deadline: string | null) => isOver({ deadline } as Assignment, Date.parse("2030-01-01T00:00:00Z"));
  expect([until(null), until("2030-01-01T00:00:00Z"), until("2030-01-01T00:00:01+00:00")]).toEqual([false, true, false]);
});
