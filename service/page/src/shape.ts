/** Mode shapes at named degrees of freedom, of a test and of a model. */

import type { Arrays } from "./npz";

export interface Shape {
  dofs: string[];
  /** Real and imaginary part at each DoF. */
  real: number[];
  imaginary: number[];
}

/** Return shape `mode` of arrays `(n_dofs, n_modes)` or `(n_modes, n_dofs)`, whichever the service sent. */
export function shapeOf(arrays: Arrays, mode: number): Shape {
  const dofs = arrays.dofs.values as string[];
  const { values, shape, complex } = arrays.shapes;
  const numbers = values as Float64Array;
  const at = (dof: number) => dof * shape[1] + mode;
  return {
    dofs,
    real: dofs.map((_, i) => (complex ? numbers[2 * at(i)] : numbers[at(i)])),
    imaginary: dofs.map((_, i) => (complex ? numbers[2 * at(i) + 1] : 0)),
  };
}

/** Return a shape turned to be as real as can be, with 1 as its largest entry. */
export function normalised({ dofs, real, imaginary }: Shape): Shape {
  let [a, b] = [0, 0];
  real.forEach((re, i) => {
    a += re * re - imaginary[i] * imaginary[i];
    b += 2 * re * imaginary[i];
  });
  const angle = -Math.atan2(b, a) / 2;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const turned = real.map((re, i) => [re * c - imaginary[i] * s, re * s + imaginary[i] * c]);
  const largest = turned.reduce((best, value) => (Math.hypot(...value) > Math.hypot(...best) ? value : best), [0, 0]);
  const scale = (Math.hypot(...largest) || 1) * (largest[0] < 0 ? -1 : 1);
  return { dofs, real: turned.map(([re]) => re / scale), imaginary: turned.map(([, im]) => im / scale) };
}

/** Return the modal assurance criterion of two shapes at the DoFs that they share. */
export function mac(a: Shape, b: Shape): number {
  const place = new Map(b.dofs.map((dof, i) => [dof, i]));
  let [re, im, aa, bb] = [0, 0, 0, 0];
  a.dofs.forEach((dof, i) => {
    const j = place.get(dof);
    if (j === undefined) return;
    re += a.real[i] * b.real[j] + a.imaginary[i] * b.imaginary[j];
    im += a.real[i] * b.imaginary[j] - a.imaginary[i] * b.real[j];
    aa += a.real[i] ** 2 + a.imaginary[i] ** 2;
    bb += b.real[j] ** 2 + b.imaginary[j] ** 2;
  });
  return aa && bb ? (re * re + im * im) / (aa * bb) : 0;
}

const LARGEST = 1.5; // of the largest measured entry, which is 1

/** Return `b` scaled to `a` by least squares at the DoFs that they share. */
export function scaledTo(a: Shape, b: Shape): Shape {
  const place = new Map(b.dofs.map((dof, i) => [dof, i]));
  let [ab, bb] = [0, 0];
  a.dofs.forEach((dof, i) => {
    const j = place.get(dof);
    if (j === undefined) return;
    ab += a.real[i] * b.real[j];
    bb += b.real[j] ** 2;
  });
  // A model may move far more where nothing is measured; then it shall not leave the drawing.
  const translations = b.real.filter((_, i) => !/:[+-]R/.test(b.dofs[i]));
  const largest = Math.max(...translations.map(Math.abs), 1e-300);
  const factor = bb ? Math.sign(ab) * Math.min(Math.abs(ab / bb), LARGEST / largest) : 1;
  return { ...b, real: b.real.map((v) => v * factor), imaginary: b.imaginary.map((v) => v * factor) };
}
