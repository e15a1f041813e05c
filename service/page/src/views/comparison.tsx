/** Measured against predicted, before and after, with the band of the random error. */

import { useMemo, useState } from "preact/hooks";
import { short } from "../format";
import { column } from "../frf";
import type { Arrays } from "../npz";
import { Actions, csv } from "../parts/actions";
import { SelectField } from "../parts/fields";
import { chartImage } from "../plot/frf-stack";
import { Chart, type Line, type Range, floorOf } from "../plot/chart";
import { Readout } from "../plot/readout";
import { ZoomBar } from "../plot/zoom";

const WIDTH_OF_BAND = 2; // standard deviations

export function Comparison({ curves, located }: { curves: Arrays; located: Range[] }) {
  const outputs = curves.outputs.values as string[];
  const inputs = curves.inputs.values as string[];
  const heldOut = curves.held_out.values as Uint8Array;
  const freq = curves.freq.values as Float64Array;
  const names = outputs.flatMap((output, j) =>
    inputs.map((input, i) => ({ value: String(j * inputs.length + i), text: `${output} / ${input}${heldOut[j] ? ", kept out of every fit" : ""}` })),
  );
  const [index, setIndex] = useState(Math.max(0, [...heldOut].indexOf(1)) * inputs.length);
  const [range, setRange] = useState<Range | null>(null);
  const [cursor, setCursor] = useState<number | null>(null);
  const { lines, envelope } = useMemo(() => linesOf(curves, index), [curves, index]);
  return (
    <div class="stack">
      <div class="toolbar">
        <SelectField label="Response" value={String(index)} set={(value) => setIndex(Number(value))} options={names} />
        <ZoomBar freq={freq} range={range} setRange={setRange} />
      </div>
      {located.length > 0 && (
        <div class="chips" role="group" aria-label="Bands in which they part">
          <span class="hint">They part at</span>
          {located.slice(0, 8).map((band) => (
            <button type="button" class="chip-button" onClick={() => setRange(about(band, freq))}>{`${short(band[0], 4)} – ${short(band[1], 4)} Hz`}</button>
          ))}
        </div>
      )}
      <Chart title="Measured and predicted magnitude" x={freq} lines={lines} envelope={envelope} unit="magnitude" log floor={floorOf(freq, [lines[2].y]) / 2} range={range} setRange={setRange} height={330} onCursor={setCursor} />
      <Readout freq={freq} index={cursor} values={lines.map((line) => ({ label: line.label, tone: line.tone, text: cursor === null ? "" : short(line.y[cursor], 4) }))} />
      <p class="hint">Grey: two standard deviations of random error about the measured curve.</p>
      <Actions downloads={[{ text: "CSV", name: "comparison.csv", from: () => csv({ "frequency, Hz": freq, ...Object.fromEntries(lines.map((line) => [line.label, line.y])) }) }, { text: "PNG", name: "comparison.png", from: () => chartImage() }]} />
    </div>
  );
}

/** Return a band with three times its width on each side, so that it is seen among its neighbours. */
function about([low, high]: Range, freq: Float64Array): Range {
  const margin = 3 * Math.max(high - low, 4 * (freq[1] - freq[0]));
  return [Math.max(freq[0], low - margin), Math.min(freq[freq.length - 1], high + margin)];
}

function linesOf(curves: Arrays, index: number): { lines: Line[]; envelope: { low: Float64Array; high: Float64Array } } {
  const magnitude = (name: string) => {
    const [real, imaginary] = column(curves, name, index);
    return real.map((re, i) => Math.hypot(re, imaginary[i]));
  };
  const measured = magnitude("measured");
  const [error] = column(curves, "random_error", index);
  const lines: Line[] = [
    { label: "before", y: magnitude("before"), tone: "--warm", dash: [6, 4], width: 1.5 },
    { label: "after", y: magnitude("after"), tone: "--accent", width: 1.8 },
    { label: "measured", y: measured, tone: "--ink", width: 1 },
  ];
  const side = (sign: number) => measured.map((value, i) => Math.max(0, value * (1 + sign * WIDTH_OF_BAND * (Number.isFinite(error[i]) ? error[i] : 0))));
  return { lines, envelope: { low: side(-1), high: side(1) } };
}
