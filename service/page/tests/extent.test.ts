import { expect, test } from "vitest";
import type { Line } from "../src/plot/chart";
import { valueRange } from "../src/plot/extent";

const x = Float64Array.from([0, 1, 2, 3]);
const line = (...y: number[]): Line => ({ label: "", tone: "--ink", y: Float64Array.from(y) });
const round = (range: [number, number]) => range.map((value) => Number(value.toPrecision(6)));

test("the curves that are drawn set the range, with a margin", () => {
  expect(round(valueRange({ x, lines: [line(1, 2, 3, 4)] }, [0, 3], [1, 4]))).toEqual([0.82, 4.18]);
});

test("curves that set the scale do so in place of those drawn, as far as they are in sight", () => {
  const scale = [Float64Array.from([100, 2, 8, 100])];
  expect(round(valueRange({ x, lines: [line(0, 0, 0, 0)], scale, log: true }, [1, 2], [0, 50]))).toEqual([round([2 / 1.4, 0])[0], 12.8]);
  expect(round(valueRange({ x, lines: [line(0, 0, 0, 0)], scale, log: true }, [0, 3], [0, 50]))[1]).toBe(160);
});

test("on a logarithmic scale nothing below the floor is shown, nor six decades below the top", () => {
  const lines = [line(0, 1, 10, 100)];
  expect(round(valueRange({ x, lines, floor: 1, log: true }, [0, 3], [0, 100]))[0]).toBe(0.714286);
  expect(valueRange({ x, lines, log: true }, [0, 3], [0, 100])[0]).toBeCloseTo(1e-4 / 1.4, 10);
});

test("curves on lines of their own are within the range", () => {
  const lines = [{ ...line(1, 1, 1, 1), own: { x: Float64Array.from([0.5, 1.5]), y: Float64Array.from([-3, 5]) } }];
  expect(round(valueRange({ x, lines }, [0, 3], [1, 1]))).toEqual([-3.48, 5.48]);
});
