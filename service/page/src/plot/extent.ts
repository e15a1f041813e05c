/** Range of values of a plot. */

import { extentIn } from "../thin";
import type { ChartProps, Range } from "./chart";

type Scaled = Pick<ChartProps, "x" | "lines" | "scale" | "floor" | "log">;

/** Return the range of values of a plot, of which an interval of `x` is in sight and `drawn` the extent of its curves there. */
export function valueRange({ x, lines, scale, floor, log }: Scaled, sight: Range, drawn: Range): Range {
  let [low, high] = scale ? extentIn(x, scale, ...sight) : drawn;
  if (floor !== undefined) low = Math.max(low, floor);
  for (const { own } of lines) {
    if (!own) continue;
    const [lower, higher] = extentIn(own.x, [own.y], ...sight);
    high = Math.max(high, higher);
    if (!log) low = Math.min(low, lower);
  }
  return margins(low, high, log);
}

function margins(low: number, high: number, log?: boolean): Range {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return log ? [0.1, 10] : [-1, 1];
  if (log) {
    const top = high > 0 ? high : 1;
    return [Math.max(low, top * 1e-6) / 1.4, top * 1.6];
  }
  const space = 0.06 * (high - low || Math.abs(high) || 1);
  return [low - space, high + space];
}
