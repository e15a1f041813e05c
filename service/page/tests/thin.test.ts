import { expect, test } from "vitest";
import { density } from "../src/plot/raster";
import { extentIn, firstAtLeast, thin } from "../src/thin";

const N = 3201;
const freq = Float64Array.from({ length: N }, (_, i) => i / 4);

test("the extent of curves is that of the values in sight, missing ones left out", () => {
  const x = [0, 1, 2, 3];
  expect(extentIn(x, [[9, 1, 2, 3], [0, 4, Number.NaN, 8]], 1, 2)).toEqual([1, 4]);
  expect(extentIn(x, [[9, 1, 2, 3]], 0, 3)).toEqual([1, 9]);
});

test("a spike of one line stays, wherever it is", () => {
  for (const at of [1, 777, 1600, 3199]) {
    const y = new Float64Array(N).fill(1);
    y[at] = 50;
    expect(thin(freq, y, 0, 800, 300)).toContain(at);
    y[at] = 0.001;
    expect(thin(freq, y, 0, 800, 300)).toContain(at);
  }
});

test("a pixel column keeps at most four lines, in their order", () => {
  const y = freq.map((f) => Math.sin(f * 12.3) + Math.sin(f));
  const kept = thin(freq, y, 0, 800, 300);
  expect(kept.length).toBeLessThanOrEqual(4 * 302);
  expect(kept).toEqual([...kept].sort((a, b) => a - b));
});

test("a window keeps its lines and one neighbour on each side", () => {
  const kept = thin(freq, freq, 100, 102, 300);
  expect(freq[kept[0]]).toBe(99.75);
  expect(freq[kept[kept.length - 1]]).toBe(102.25);
});

test("a missing value stays as a gap", () => {
  const y = new Float64Array(N).fill(1);
  y[1000] = Number.NaN;
  expect(thin(freq, y, 0, 800, 100)).toContain(1000);
});

test("the first line at or above a frequency is found", () => {
  expect(firstAtLeast(freq, 0.3)).toBe(2);
  expect(firstAtLeast(freq, 900)).toBe(N);
});

test("a spike of one line in one of 500 curves is painted to its top", () => {
  const curves = Array.from({ length: 500 }, () => new Float32Array(N).fill(0));
  curves[321][1234] = 0.9;
  const window = { width: 900, height: 300, left: 0, right: 800, low: -1, high: 1 };
  const counts = density(freq, curves, window, 0, N);
  const column = Math.floor((freq[1234] * 900) / 800);
  const top = Math.round(((1 - 0.9) * 299) / 2); // the row of level 0.9
  const rows = Array.from({ length: 300 }, (_, row) => counts[row * 900 + column]);
  expect(rows.findIndex((count) => count > 0)).toBe(top);
  expect(rows[150]).toBe(500); // all others run through the middle: level 0, of rows 149 and 150 the nearer
});

test("a zoomed curve of few lines is drawn without holes", () => {
  const counts = density(freq, [Float32Array.from(freq, (f) => f / 800)], { width: 400, height: 100, left: 100, right: 103, low: 0, high: 1 }, 399, 414);
  for (let column = 0; column < 400; column++) {
    let total = 0;
    for (let row = 0; row < 100; row++) total += counts[row * 400 + column];
    expect(total).toBeGreaterThan(0);
  }
});
