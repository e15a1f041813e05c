import { expect, test } from "vitest";
import { type Fit, fitted, misfit } from "../src/fit";
import { ticks } from "../src/plot/figure";

const blank = { mode: 1, method: "line_fit", response: "1:+Y", measured: [], curve_freq: [], curve: [], quality: {}, details: {}, complex_details: {} };

/** Fit of a mode at 10 Hz, loss factor 0.02, with 1/kg. */
const fit = (change: Partial<Fit>): Fit => ({
  ...blank, damping: "structural", kind: "receptance", frequency: 10, loss_factor: 0.02, modal_constant: [1, 0], residual: [0, 0], freq: [], used: [], cleaned: [], ...change,
});

test("at resonance a structurally damped mode is A/(i eta omega^2)", () => {
  const [re, im] = fitted(fit({}), 10);
  expect(re).toBeCloseTo(0, 12);
  expect(im).toBeCloseTo(-1 / (0.02 * (20 * Math.PI) ** 2), 12);
});

test("a viscously damped mode of a real constant is A/(omega_r^2 - omega^2 + 2 i zeta omega_r omega)", () => {
  const [natural, omega] = [20 * Math.PI, 20 * Math.PI * 0.7];
  const [a, b] = [natural ** 2 - omega ** 2, 0.02 * natural * omega];
  const [re, im] = fitted(fit({ damping: "viscous" }), 7);
  expect(re).toBeCloseTo(a / (a * a + b * b), 12);
  expect(im).toBeCloseTo(-b / (a * a + b * b), 12);
});

test("an inertance is -omega^2 times the receptance, and the residual is in its unit", () => {
  const [re, im] = fitted(fit({ kind: "inertance", residual: [3, 4] }), 10);
  expect(re).toBeCloseTo(3, 9);
  expect(im).toBeCloseTo(4 + 1 / 0.02, 9);
});

test("what a fit leaves is counted at the lines that it used", () => {
  const whole = fit({ kind: "inertance", freq: [9, 10, 11], used: [true, true, false] });
  const cleaned = whole.freq.map((freq) => fitted(whole, freq));
  expect(misfit({ ...whole, cleaned })).toBe(0);
  const off = cleaned.map(([re, im], i) => (i === 2 ? [9e9, 0] : [1.1 * re, 1.1 * im]) as [number, number]);
  expect(misfit({ ...whole, cleaned: off })).toBeCloseTo(0.1 / 1.1, 9);
});

test("ticks are round and inside", () => {
  expect(ticks([0.3, 9.7], 5)).toEqual([2, 4, 6, 8]);
  expect(ticks([-0.12, 0.13], 5)).toEqual([-0.1, -0.05, 0, 0.05, 0.1]);
});
