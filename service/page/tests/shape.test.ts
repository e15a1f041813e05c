import { expect, test } from "vitest";
import { withoutWraps } from "../src/frf";
import { mac, normalised, scaledTo } from "../src/shape";
import { literal } from "../src/python";
import { beamBody } from "../src/views/structure-panel";

const dofs = ["1:+Y", "2:+Y", "3:+Y"];

test("shapes that differ by a complex factor have a MAC of 1, orthogonal ones of 0", () => {
  const a = { dofs, real: [1, 2, -1], imaginary: [0, 0, 0] };
  const b = { dofs, real: [0, 0, 0], imaginary: [-3, -6, 3] };
  expect(mac(a, b)).toBeCloseTo(1, 12);
  expect(mac(a, { dofs, real: [1, 0, 1], imaginary: [0, 0, 0] })).toBeCloseTo(0, 12);
});

test("a shape is turned to be real, its largest entry 1", () => {
  const turned = normalised({ dofs, real: [0, 0, 0], imaginary: [-1, -2, 1] });
  turned.real.forEach((value, i) => expect(value).toBeCloseTo([0.5, 1, -0.5][i], 12));
  turned.imaginary.forEach((value) => expect(value).toBeCloseTo(0, 12));
});

test("a model's shape is scaled to the measured one", () => {
  const measured = { dofs, real: [0.5, 1, -0.5], imaginary: [0, 0, 0] };
  const model = { dofs: [...dofs, "4:+Y"], real: [-1, -2, 1, 2], imaginary: [0, 0, 0, 0] };
  expect(scaledTo(measured, model).real).toEqual([0.5, 1, -0.5, -1]);
  const turning = { dofs: [...dofs, "3:+RZ"], real: [-1, -2, 1, 40], imaginary: [0, 0, 0, 0] };
  expect(scaledTo(measured, turning).real.slice(0, 3)).toEqual([0.5, 1, -0.5]); // rotations are not drawn
  const wild = { ...model, real: [-1, -2, 1, 40] };
  expect(Math.max(...scaledTo(measured, wild).real.map(Math.abs))).toBe(1.5); // it stays in the drawing
});

test("a phase has a gap where it wraps", () => {
  const phase = withoutWraps(Float64Array.from([170, 179, -179, -170]));
  expect(Number.isNaN(phase[2])).toBe(true);
  expect(phase[3]).toBe(-170);
});

test("values are written as Python has them", () => {
  expect(literal({ at: null, on: true, to: ["1:+Y", 2e-5] })).toBe('{"at": None, "on": True, "to": ["1:+Y", 0.00002]}');
});

test("a beam is built from millimetres and gigapascals", () => {
  const body = beamBody({ length: 1.5, width: 50, height: 10, modulus: 209, density: 7800, loss: 0.005, elements: 20, ends: "clamped" });
  expect(body.section.area).toBeCloseTo(5e-4, 12);
  expect(body.section.second_moment).toBeCloseTo(4.1667e-9, 12);
  expect(body.supports).toEqual([{ node: 1, directions: ["X", "Y", "RZ"] }]);
});
