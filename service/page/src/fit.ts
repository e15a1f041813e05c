/** The fit of one mode in one FRF, and what it leaves of the measured lines. */

import { get } from "./api";

export type Complex = [number, number];

export interface Fit {
  mode: number;
  method: string;
  damping: "structural" | "viscous";
  kind: "receptance" | "mobility" | "inertance";
  response: string;
  freq: number[];
  used: boolean[];
  measured: Complex[];
  cleaned: Complex[];
  curve_freq: number[];
  curve: Complex[];
  frequency: number;
  loss_factor: number;
  modal_constant: Complex;
  residual: Complex;
  quality: Record<string, number | null>;
  details: Record<string, number[] | number[][]>;
  complex_details: Record<string, Complex[] | Complex[][]>;
}

export function loadFit(model: string, mode: number, response: string, reference?: string): Promise<Fit> {
  const query = new URLSearchParams({ mode: String(mode), response, ...(reference && { reference }) });
  return get<Fit>(`/modal-models/${model}/fits?${query}`);
}

const times = ([a, b]: Complex, [c, d]: Complex): Complex => [a * c - b * d, a * d + b * c];

const over = ([a, b]: Complex, [c, d]: Complex): Complex => {
  const size = c * c + d * d;
  return [(a * c + b * d) / size, (b * c - a * d) / size];
};

/** Return the receptance of the fitted mode at a frequency in Hz. */
function receptance({ damping, frequency, loss_factor: eta, modal_constant: a }: Fit, freq: number): Complex {
  const [omega, natural] = [2 * Math.PI * freq, 2 * Math.PI * frequency];
  if (damping === "structural") return over(a, [natural ** 2 - omega ** 2, eta * natural ** 2]);
  const zeta = eta / 2;
  const pole: Complex = [natural * Math.sqrt(1 - zeta ** 2), natural * zeta];
  const c: Complex = [a[0] / (2 * pole[0]), a[1] / (2 * pole[0])];
  const direct = over(c, [pole[0] - omega, pole[1]]);
  const mirror = over([c[0], -c[1]], [pole[0] + omega, -pole[1]]);
  return [direct[0] + mirror[0], direct[1] + mirror[1]];
}

/** Return mode and residual as the fit has them at a frequency, in the unit of its responses. */
export function fitted(fit: Fit, freq: number): Complex {
  const omega = 2 * Math.PI * freq;
  const factor: Complex = fit.kind === "inertance" ? [-(omega ** 2), 0] : fit.kind === "mobility" ? [0, omega] : [1, 0];
  const [re, im] = times(factor, receptance(fit, freq));
  return [re + fit.residual[0], im + fit.residual[1]];
}

/** Return the rms of what the fit leaves of its lines, over the rms of these lines. */
export function misfit(fit: Fit): number {
  let [left, whole] = [0, 0];
  fit.freq.forEach((freq, i) => {
    if (!fit.used[i]) return;
    const [re, im] = fitted(fit, freq);
    left += (fit.cleaned[i][0] - re) ** 2 + (fit.cleaned[i][1] - im) ** 2;
    whole += fit.cleaned[i][0] ** 2 + fit.cleaned[i][1] ** 2;
  });
  return Math.sqrt(left / whole);
}
