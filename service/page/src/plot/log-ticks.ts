/**
 * Ticks of a logarithmic axis. Those of uPlot 1.6 never end where a scale begins little below a power of ten,
 * as at 0.0096: its sum is rounded to 0 there.
 */

/** Return one to nine times every power of ten inside an interval above 0. */
export function logTicks(low: number, high: number): number[] {
  const [first, last] = [low, high].map((value) => Math.floor(Math.log10(value)));
  if (!Number.isFinite(last - first)) return [];
  const powers = Array.from({ length: last - first + 1 }, (_, i) => first + i);
  const all = powers.flatMap((power) => [1, 2, 3, 4, 5, 6, 7, 8, 9].map((factor) => Number(`${factor}e${power}`)));
  return all.filter((value) => value >= low && value <= high);
}

/** Return the splits of a logarithmic axis that are powers of ten; all where there are hardly any. */
export function decades(_plot: unknown, splits: number[]): (number | null)[] {
  const powers = splits.map((value) => (isPower(value) ? value : null));
  return powers.filter((value) => value !== null).length > 1 ? powers : splits;
}

const isPower = (value: number) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6;

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** Return the text of a tick. */
export function tickText(value: number | null, log?: boolean): string {
  if (value === null) return "";
  if (!log) return String(Number(value.toPrecision(6))).replace("-", "−");
  if (!isPower(value)) return String(Number(value.toPrecision(2)));
  const text = String(Math.round(Math.log10(value)));
  return `10${[...text].map((c) => (c === "-" ? "⁻" : SUPERSCRIPTS[Number(c)])).join("")}`;
}
