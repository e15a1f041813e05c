/** Thinning of curves for plots: what a pixel column shows are its lowest and its highest value. */

/**
 * Return the indices of retained samples: first, lowest, highest and last of every pixel column, and one
 * neighbour on each side of the window. A sample that is NaN is kept where it makes a gap.
 */
export function thin(x: ArrayLike<number>, y: ArrayLike<number>, low: number, high: number, columns: number): number[] {
  const begin = Math.max(0, firstAtLeast(x, low) - 1);
  const end = Math.min(x.length, firstAtLeast(x, high) + 2);
  if (end - begin <= 2 * columns) return Array.from({ length: end - begin }, (_, i) => begin + i);
  const kept: number[] = [];
  const scale = columns / (high - low);
  let column = Number.NaN;
  let first = 0, lowest = 0, highest = 0, last = 0;
  const flush = () => {
    if (Number.isNaN(column)) return;
    for (const i of [...new Set([first, lowest, highest, last])].sort((a, b) => a - b)) kept.push(i);
    column = Number.NaN;
  };
  for (let i = begin; i < end; i++) {
    if (Number.isNaN(y[i])) {
      flush();
      kept.push(i);
      continue;
    }
    const here = Math.floor((x[i] - low) * scale);
    if (here !== column) {
      flush();
      column = here;
      first = lowest = highest = i;
    }
    if (y[i] < y[lowest]) lowest = i;
    if (y[i] > y[highest]) highest = i;
    last = i;
  }
  flush();
  return kept;
}

/** Return the least and the greatest value of curves over an interval of `x`. */
export function extentIn(x: ArrayLike<number>, curves: ArrayLike<number>[], low: number, high: number): [number, number] {
  const [begin, end] = [firstAtLeast(x, low), Math.min(x.length, firstAtLeast(x, high) + 1)];
  let [least, greatest] = [Infinity, -Infinity];
  for (const y of curves) {
    for (let i = begin; i < end; i++) {
      if (y[i] < least) least = y[i];
      if (y[i] > greatest) greatest = y[i];
    }
  }
  return [least, greatest];
}

/** Return the first index at which ascending `x` is at least `value`. */
export function firstAtLeast(x: ArrayLike<number>, value: number): number {
  let low = 0;
  let high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}
