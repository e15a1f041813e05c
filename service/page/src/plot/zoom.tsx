/** Buttons that zoom, for those who do not drag. */

import { short } from "../format";
import { type Range, fullRange } from "./chart";

export function ZoomBar({ freq, range, setRange }: { freq: Float64Array; range: Range | null; setRange(range: Range | null): void }) {
  const [first, last] = fullRange(freq);
  const [low, high] = range ?? [first, last];
  const by = (factor: number, shift: number) => {
    const middle = (low + high) / 2 + shift * (high - low);
    const half = Math.min(((high - low) / 2) * factor, (last - first) / 2);
    const from = Math.min(Math.max(first, middle - half), last - 2 * half);
    setRange(factor > 1 && 2 * half >= last - first ? null : [from, from + 2 * half]);
  };
  return (
    <div class="zoom" role="group" aria-label="Frequency range">
      <button type="button" aria-label="Lower frequencies" disabled={low <= first} onClick={() => by(1, -0.3)}>←</button>
      <button type="button" aria-label="Zoom in" onClick={() => by(0.5, 0)}>+</button>
      <button type="button" aria-label="Zoom out" disabled={!range} onClick={() => by(2, 0)}>−</button>
      <button type="button" aria-label="Higher frequencies" disabled={high >= last} onClick={() => by(1, 0.3)}>→</button>
      <button type="button" disabled={!range} onClick={() => setRange(null)}>All</button>
      <span class="zoom-range">{short(low, 5)} – {short(high, 5)} Hz</span>
    </div>
  );
}
