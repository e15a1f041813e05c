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
