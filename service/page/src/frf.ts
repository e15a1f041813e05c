/** Frequency response functions as arrays of numbers, and their representations in plots. */

import type { Arrays } from "./npz";
import { firstAtLeast } from "./thin";

export type Representation = "magnitude" | "phase" | "real" | "imaginary" | "nyquist";

export interface Curve {
  output: string;
  input: string;
  real: Float64Array;
  imaginary: Float64Array;
  coherence: Float64Array | null;
}

export interface Frfs {
  freq: Float64Array;
  kind: string;
  curves: Curve[];
}

const UNITS: Record<string, string> = { inertance: "m/(s² N)", mobility: "m/(s N)", receptance: "m/N" };

export function unitOf(kind: string): string {
  return UNITS[kind] ?? "1";
}

/** Return column `index` of an array (n, ...) as real and imaginary part. */
export function column(arrays: Arrays, name: string, index: number): [Float64Array, Float64Array] {
  const { values, shape, complex } = arrays[name];
  const width = shape.slice(1).reduce((product, n) => product * n, 1);
  const numbers = values as Float64Array;
  const real = new Float64Array(shape[0]);
  const imaginary = new Float64Array(shape[0]);
  for (let i = 0; i < shape[0]; i++) {
    const at = i * width + index;
    real[i] = complex ? numbers[2 * at] : numbers[at];
    imaginary[i] = complex ? numbers[2 * at + 1] : 0;
  }
  return [real, imaginary];
}

export function frfsOf(arrays: Arrays): Frfs {
  const outputs = arrays.outputs.values as string[];
  const inputs = arrays.inputs.values as string[];
  const kind = (arrays.kind.values as string[])[0];
  const coherence = arrays.coherence?.values.length ? arrays.coherence : null;
  const curves = outputs.flatMap((output, j) =>
    inputs.map((input, i) => {
      const [real, imaginary] = column(arrays, "values", j * inputs.length + i);
      const perFrf = coherence?.shape.length === 3;
      const of = coherence && column(arrays, "coherence", perFrf ? j * inputs.length + i : j)[0];
      return { output, input, real, imaginary, coherence: of };
    }),
  );
  return { freq: arrays.freq.values as Float64Array, kind, curves };
}

type Part = (re: number, im: number) => number;

const PARTS: Record<Exclude<Representation, "nyquist">, Part> = {
  magnitude: (re, im) => Math.sqrt(re * re + im * im), // hypot takes ten times as long
  phase: (re, im) => (Math.atan2(im, re) * 180) / Math.PI,
  real: (re) => re,
  imaginary: (_, im) => im,
};

export function part(curve: Curve, representation: Exclude<Representation, "nyquist">): Float64Array {
  const of = PARTS[representation];
  return curve.real.map((re, i) => of(re, curve.imaginary[i]));
}

/** Return a phase with gaps (NaN) where it wraps, so that no line is drawn across the plot. */
export function withoutWraps(phase: Float64Array): Float64Array {
  return phase.map((value, i) => (i > 0 && Math.abs(value - phase[i - 1]) > 270 ? Number.NaN : value));
}

/** Return whether two tests have the same frequency lines. */
export function sameLines(a: Float64Array, b: Float64Array): boolean {
  return a.length === b.length && a[0] === b[0] && a[a.length - 1] === b[b.length - 1];
}

/** Return the values nearest to other frequencies; NaN beyond the ends. */
export function nearest(x: Float64Array, y: Float64Array, at: Float64Array): Float64Array {
  return at.map((freq) => {
    if (freq < x[0] || freq > x[x.length - 1]) return Number.NaN;
    const after = firstAtLeast(x, freq);
    return y[after > 0 && freq - x[after - 1] < x[after] - freq ? after - 1 : after];
  });
}
