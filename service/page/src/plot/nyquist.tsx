/** Nyquist plots: a resonance is a circle. Both axes have one scale. */

import type { Curve } from "../frf";
import { short } from "../format";
import type { Range } from "./chart";

interface NyquistProps {
  curves: { curve: Curve; label: string; freq: Float64Array; tone: string }[];
  range: Range;
  unit: string;
  svgRef?: { current: SVGSVGElement | null };
}

const SIZE = 460;
const MARGIN = 52;
const MOST = 3000; // lines of a curve; a window with more than this shows no circle anyway

export function Nyquist({ curves, range, unit, svgRef }: NyquistProps) {
  const [low, high] = range;
  const inside = new Map([...new Set(curves.map(({ freq }) => freq))].map((freq) => [freq, linesBetween(freq, range)]));
  let [left, right, bottom, top] = [0, 0, 0, 0];
  for (const { curve, freq } of curves) {
    for (const i of inside.get(freq)!) {
      left = Math.min(left, curve.real[i]);
      right = Math.max(right, curve.real[i]);
      bottom = Math.min(bottom, curve.imaginary[i]);
      top = Math.max(top, curve.imaginary[i]);
    }
  }
  const extent = Math.max(right - left, top - bottom, 1e-300);
  const scale = (SIZE - 2 * MARGIN) / extent;
  const px = (re: number) => MARGIN + (re - left) * scale + (SIZE - 2 * MARGIN - (right - left) * scale) / 2;
  const py = (im: number) => SIZE - MARGIN - (im - bottom) * scale - (SIZE - 2 * MARGIN - (top - bottom) * scale) / 2;
  const path = (curve: Curve, lines: number[]) => `M${lines.map((i) => `${px(curve.real[i]).toFixed(1)} ${py(curve.imaginary[i]).toFixed(1)}`).join("L")}`;
  const few = curves.reduce((sum, { freq }) => sum + inside.get(freq)!.length, 0) <= 400;
  return (
    <svg ref={svgRef} class="nyquist" viewBox={`0 0 ${SIZE} ${SIZE}`} role="img" aria-label={`Nyquist plot of ${curves.length} FRFs, ${short(low)} to ${short(high)} Hz`}>
      <g class="frame">
        <path d={`M${MARGIN / 2} ${py(0)}H${SIZE - MARGIN / 2}M${px(0)} ${MARGIN / 2}V${SIZE - MARGIN / 2}`} />
        <text x={SIZE - MARGIN / 2} y={py(0) - 8} class="end">{`Re, ${unit}`}</text>
        <text x={px(0) + 8} y={MARGIN / 2 + 4}>Im</text>
        <Scale length={extent} scale={scale} />
      </g>
      {curves.map(({ curve, label, freq, tone }) => {
        const lines = inside.get(freq)!;
        return (
          <g style={{ color: tone.startsWith("--") ? `var(${tone})` : tone }}>
            <path class="locus" d={lines.length ? path(curve, lines) : ""}><title>{label}</title></path>
            {few && lines.map((line) => <circle class="locus-dot" cx={px(curve.real[line])} cy={py(curve.imaginary[line])} r="2.6"><title>{`${label}, ${short(freq[line], 6)} Hz`}</title></circle>)}
          </g>
        );
      })}
    </svg>
  );
}

/** Return the indices of the lines inside a range; of very many every second, third ... */
function linesBetween(freq: Float64Array, [low, high]: Range): number[] {
  const inside = [...freq.keys()].filter((i) => freq[i] >= low && freq[i] <= high);
  return inside.filter((_, k) => k % Math.ceil(inside.length / MOST) === 0);
}

function Scale({ length, scale }: { length: number; scale: number }) {
  const power = 10 ** Math.floor(Math.log10(length / 4));
  const step = [1, 2, 5].map((n) => n * power).filter((n) => n <= length / 3).at(-1) ?? power;
  return (
    <g class="scale">
      <path d={`M${MARGIN / 2} ${SIZE - 14}v-6h${(step * scale).toFixed(1)}v6`} />
      <text x={MARGIN / 2 + step * scale + 8} y={SIZE - 12}>{short(step, 2)}</text>
    </g>
  );
}
