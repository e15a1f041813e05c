import { expect, test } from "vitest";
import { bodyOf, packed, unpacked, usualRig } from "../src/rig";
import { address, parse } from "../src/state";

const DOFS = Array.from({ length: 21 }, (_, i) => [`${i + 1}:+Y`, `${i + 1}:+RZ`]).flat();
const rig = usualRig(DOFS, [24, 65, 128, 211, 316, 441, 588, 755, 944]);

test("an address brings everything back", () => {
  const state = { view: "measure" as const, s: "a1", t: ["m2", "m1"], x: "x1", f: ["x2", "x3"], rig: packed({ ...rig, averages: 7 }) };
  const back = parse(address(state));
  expect(back).toEqual(state);
  expect(unpacked(back.rig, rig)).toEqual({ ...rig, averages: 7 });
});

test("an address that makes no sense is the first view", () => {
  expect(parse("#nonsense?zz=1")).toEqual({ view: "rig", t: [], f: [] });
  expect(unpacked("{broken", rig)).toEqual(rig);
  expect(unpacked('{"averages":"many","unknown":1}', rig)).toEqual(rig);
});

test("a usual rig drives a tip, listens at eleven nodes and covers eight modes", () => {
  expect(rig.drive).toBe("1:+Y");
  expect(rig.responses).toHaveLength(11);
  expect(rig.frequencyMax).toBe(800);
});

test("a clamped beam is driven at its free tip, a plate across its plane", () => {
  expect(usualRig(DOFS.slice(2), [4]).drive).toBe("21:+Y");
  expect(usualRig(["1:+Z", "1:+RX", "1:+RY", "2:+Z"], [56]).responses[0]).toBe("1:+Z");
});

test("a hammer has no shaker's parts", () => {
  const body = bodyOf({ ...rig, exciter: "hammer", stingerStiffness: 1e6 });
  expect(body).not.toHaveProperty("stinger");
  expect(body).not.toHaveProperty("force_transducer");
  expect(body.analyser).toHaveProperty("excitation.kind", "impact");
});
