import { expect, test } from "vitest";
import { type Entry, shown } from "../src/saved";
import { address, parse } from "../src/state";

const entry = (made_from: Record<string, string>): Entry => ({ id: "i1", created: "2026-01-02T03:04:05Z", name: "", comment: "", made_from });
const open = parse("#rig?s=s0&x=x0&u=u0&d=d0&t=t0&f=f0&j=j0");

test("a stored test takes the place of what is shown, on the same structure", () => {
  expect(address({ ...open, ...shown("measurement", entry({ rig_id: "r1" })) })).toBe("#measure?s=s0&t=i1");
});

test("what is made of others comes with them", () => {
  expect(address({ ...open, ...shown("modal_model", entry({ measurement_id: "t1" })) })).toBe("#extract?s=s0&x=i1&t=t1");
  expect(address({ ...open, ...shown("update", entry({ structure_id: "s1", modal_model_id: "x1" })) })).toBe("#correlate?s=s1&x=x1&u=i1");
  expect(address({ ...open, ...shown("diagnosis", entry({ structure_id: "s1", measurement_id: "t1" })) })).toBe("#diagnose?s=s1&d=i1&t=t1");
});

test("modes of a structure alone have no test", () => {
  expect(shown("modal_model", entry({ structure_id: "s1" })).t).toEqual([]);
});
