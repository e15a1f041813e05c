/**
 * Many curves at once, as the density of their lines: one pass over the samples fills a count a pixel.
 * Every sample of every curve is in it; a path of its own for each curve would take seconds a frame.
 */

export interface Window {
  width: number;
  height: number;
  /** x of the left and the right edge, level of the lower and the upper edge. */
  left: number;
  right: number;
  low: number;
  high: number;
}

/** Return how many curves pass each pixel, row by row from the top, added to `counts`; `x` ascends. */
export function density(x: ArrayLike<number>, curves: ArrayLike<number>[], window: Window, begin: number, end: number, counts = new Uint16Array(window.width * window.height)): Uint16Array {
  const { width, height } = window;
  const toColumn = width / (window.right - window.left);
  const toRow = (height - 1) / (window.high - window.low);
  const columns = new Float64Array(end - begin);
  for (let i = begin; i < end; i++) columns[i - begin] = (x[i] - window.left) * toColumn;
  for (const levels of curves) addCurve(counts, columns, levels, begin, { width, height, high: window.high, toRow });
  return counts;
}

interface Grid {
  width: number;
  height: number;
  high: number;
  toRow: number;
}

function addCurve(counts: Uint16Array, columns: Float64Array, levels: ArrayLike<number>, begin: number, grid: Grid): void {
  const { width, height, high, toRow } = grid;
  let pending = -1; // column whose span is not written yet
  let top = 0, bottom = 0;
  const write = (column: number, from: number, to: number) => {
    if (column < 0 || column >= width) return;
    const first = Math.max(0, Math.round(from));
    const last = Math.min(height - 1, Math.round(to));
    for (let at = first * width + column; at <= last * width + column; at += width) counts[at]++;
  };
  const extend = (column: number, a: number, b: number) => {
    const from = a < b ? a : b;
    const to = a < b ? b : a;
    if (column !== pending) {
      if (pending >= 0) write(pending, top, bottom);
      pending = column;
      top = from;
      bottom = to;
    } else {
      if (from < top) top = from;
      if (to > bottom) bottom = to;
    }
  };
  let x0 = columns[0];
  let y0 = (high - levels[begin]) * toRow;
  for (let i = 1; i < columns.length; i++) {
    const x1 = columns[i];
    const y1 = (high - levels[begin + i]) * toRow;
    if (y0 === y0 && y1 === y1) {
      const first = Math.floor(x0);
      const last = Math.floor(x1);
      if (first === last) extend(first, y0, y1);
      else {
        const slope = (y1 - y0) / (x1 - x0);
        for (let column = Math.max(first, -1); column <= Math.min(last, width); column++) {
          const enter = column === first ? y0 : y0 + (column - x0) * slope;
          const leave = column === last ? y1 : y0 + (column + 1 - x0) * slope;
          extend(column, enter, leave);
        }
      }
    }
    x0 = x1;
    y0 = y1;
  }
  if (pending >= 0) write(pending, top, bottom);
}

/** Paint counts in one colour: the more curves, the more opaque; one alone is plainly seen. */
export function paint(counts: Uint16Array, colour: [number, number, number], into: ImageData): void {
  const table = new Uint32Array(256);
  for (let n = 1; n < 256; n++) {
    const alpha = Math.round(255 * (1 - 0.55 * 0.86 ** (n - 1)));
    table[n] = (alpha << 24) | (colour[2] << 16) | (colour[1] << 8) | colour[0];
  }
  const pixels = new Uint32Array(into.data.buffer);
  for (let i = 0; i < counts.length; i++) pixels[i] = table[counts[i] > 255 ? 255 : counts[i]];
}
