/** FRFs of one or several tests: a representation of choice, and coherence under it. */

import type { ComponentChildren } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";
import { short } from "../format";
import { type Curve, type Frfs, type Representation, nearest, part, sameLines, unitOf, withoutWraps } from "../frf";
import { Actions, csv, svgFile } from "../parts/actions";
import { Choice } from "../parts/fields";
import { Chart, type ChartProps, type Line, MANY, type Range, floorOf, fullRange } from "./chart";
import { tone } from "./colour";
import { Nyquist } from "./nyquist";
import { Readout } from "./readout";
import { ZoomBar } from "./zoom";

export interface Test {
  id: string;
  name: string;
  frfs: Frfs;
}

interface StackProps {
  tests: Test[];
  python?: () => string;
  bands?: Range[];
  onBand?: ChartProps["onBand"];
  /** Representation with which to begin. */
  first?: Representation;
  /** FRFs of the first test after all averages, where those after fewer are shown: they set the scale. */
  whole?: Frfs;
  /** Stands below the plots. */
  under?: ComponentChildren;
}

const REPRESENTATIONS: { value: Representation; text: string }[] = [
  { value: "magnitude", text: "Magnitude" },
  { value: "phase", text: "Phase" },
  { value: "real", text: "Real" },
  { value: "imaginary", text: "Imaginary" },
  { value: "nyquist", text: "Nyquist" },
];

interface Shown {
  label: string;
  curve: Curve;
  freq: Float64Array;
  tone: string;
}

export function FrfStack({ tests, python, bands, onBand, first = "magnitude", whole, under }: StackProps) {
  const [representation, setRepresentation] = useState<Representation>(first);
  const [log, setLog] = useState(true);
  const [range, setRange] = useState<Range | null>(null);
  const [chosen, setChosen] = useState<string[] | null>(null);
  const [cursor, setCursor] = useState<number | null>(null);
  const svg = useRef<SVGSVGElement>(null);
  const main = tests[0].frfs;
  const names = useMemo(() => main.curves.map(nameOf), [main]);
  const labels = chosen ?? names;
  const shown = useMemo(() => shownCurves(tests, labels), [tests, labels]);
  const lines = useMemo(() => (representation === "nyquist" ? [] : shown.map((one) => lineOf(one, representation, main.freq))), [shown, representation]);
  const scale = useMemo(() => {
    if (!whole || whole === main || representation === "nyquist") return undefined;
    return shownCurves([{ ...tests[0], frfs: whole }, ...tests.slice(1)], labels).map((one) => lineOf(one, representation, main.freq).y);
  }, [whole, tests, labels, representation]);
  const coherences = useMemo(
    () => shown.filter(({ curve }) => curve.coherence).map((one) => onLines(one, one.curve.coherence!, main.freq)),
    [shown],
  );
  const floor = useMemo(() => floorOf(main.freq, scale ?? lines.map((line) => line.y)), [lines, scale]);
  // Kept, for a plot of 500 curves is drawn at every turn of the wheel.
  const choice = useMemo(() => <ResponseChoice names={names} chosen={labels} set={setChosen} />, [names, labels]);
  const choose = (next: Representation) => {
    if (next === "nyquist" && !range) setRange(aroundHighest(main));
    setRepresentation(next);
  };
  const unit = representation === "phase" ? "phase, °" : `${main.kind}, ${unitOf(main.kind)}`;
  const common = { x: main.freq, range, setRange, sync: "frf", bands, onBand };
  return (
    <div class="stack">
      <div class="toolbar">
        <Choice<Representation> label="Representation" value={representation} set={choose} options={REPRESENTATIONS} />
        {representation === "magnitude" && <Choice label="Scale" value={log ? "log" : "linear"} set={(scale) => setLog(scale === "log")} options={[{ value: "log", text: "Log" }, { value: "linear", text: "Linear" }]} />}
        <ZoomBar freq={main.freq} range={range} setRange={setRange} />
      </div>
      {representation === "nyquist" ? (
        <Nyquist svgRef={svg} range={range ?? fullRange(main.freq)} unit={unitOf(main.kind)} curves={shown.slice(0, 24)} />
      ) : (
        <Chart {...common} title={`${representation} of ${lines.length} FRFs`} lines={lines} scale={scale} unit={unit} log={representation === "magnitude" && log} floor={representation === "magnitude" && log ? floor : undefined} limits={representation === "phase" ? [-190, 190] : undefined} height={340} onCursor={setCursor} />
      )}
      {representation !== "nyquist" && coherences.length > 0 && (
        <Chart {...common} title="Coherence" lines={coherences} unit="coherence" limits={[0, 1.04]} height={130} />
      )}
      {representation !== "nyquist" && <Readout freq={main.freq} index={cursor} values={valuesAt(lines, cursor)} />}
      {under}
      {tests.some((test) => test.frfs.kind !== main.kind) && <p class="notice">These tests are of different kinds of FRF: only those of one kind can be compared.</p>}
      {lines.length > MANY && <p class="hint">All {lines.length} curves are drawn; the darker, the more of them.</p>}
      {choice}
      <Actions
        python={python}
        downloads={[
          { text: "CSV", name: whole && whole !== main ? "frf-first-averages.csv" : "frf.csv", from: () => csv(table(main, shown)) },
          { text: "UFF", name: `${tests[0].id}.uff`, from: `v1/measurements/${tests[0].id}/frf.uff` },
          { text: "npz", name: `${tests[0].id}.npz`, from: `v1/measurements/${tests[0].id}/arrays` },
          representation === "nyquist"
            ? { text: "SVG", name: "nyquist.svg", from: () => svgFile(svg.current!) }
            : { text: "PNG", name: `${representation}.png`, from: () => chartImage() },
        ]}
      />
    </div>
  );
}

const nameOf = (curve: Curve) => `${curve.output} / ${curve.input}`;

function shownCurves(tests: Test[], labels: string[]): Shown[] {
  const wanted = new Set(labels);
  return tests.flatMap((test, t) => {
    const curves = test.frfs.curves.filter((curve) => wanted.has(nameOf(curve)));
    return curves.map((curve, i) => ({
      curve,
      freq: test.frfs.freq,
      label: tests.length > 1 ? `${curve.output}, ${test.name}` : curve.output,
      tone: tests.length > 1 ? tone(t, tests.length) : tone(i, curves.length),
    }));
  });
}

function lineOf(shown: Shown, representation: Exclude<Representation, "nyquist">, main: Float64Array): Line {
  const y = part(shown.curve, representation);
  return onLines(shown, representation === "phase" ? withoutWraps(y) : y, main);
}

/** Return a curve for a plot over the lines of the main test: drawn over its own, where those are others. */
function onLines({ label, tone: colour, freq }: Shown, y: Float64Array, main: Float64Array): Line {
  if (sameLines(freq, main)) return { label, tone: colour, y };
  return { label, tone: colour, y: nearest(freq, y, main), own: { x: freq, y } };
}

/** Return the values at the cursor; of many curves the highest and the lowest. */
function valuesAt(lines: Line[], cursor: number | null) {
  const value = (line: Line, words = "") => ({ label: `${words}${line.label}`, tone: line.tone, text: cursor === null ? "" : short(line.y[cursor], 4) });
  if (lines.length <= MANY) return lines.map((line) => value(line));
  if (cursor === null) return [];
  const most = (sign: number) => lines.reduce((best, line) => (sign * line.y[cursor] > sign * best.y[cursor] ? line : best));
  return [value({ ...most(1), tone: "--ink" }, "highest "), value({ ...most(-1), tone: "--ink" }, "lowest ")];
}

function table(frfs: Frfs, shown: Shown[]): Record<string, ArrayLike<number>> {
  const columns: Record<string, ArrayLike<number>> = { "frequency, Hz": frfs.freq };
  for (const { label, curve, freq } of shown) {
    if (!sameLines(freq, frfs.freq)) columns[`${label} frequency, Hz`] = freq;
    columns[`${label} real, ${unitOf(frfs.kind)}`] = curve.real;
    columns[`${label} imaginary, ${unitOf(frfs.kind)}`] = curve.imaginary;
    if (curve.coherence) columns[`${label} coherence`] = curve.coherence;
  }
  return columns;
}

const LINES_OF_A_CIRCLE = 14; // on each side of its resonance

/** Return the range about the highest resonance: there a Nyquist plot shows a circle, over all it is a tangle. */
function aroundHighest(frfs: Frfs): Range {
  const magnitude = part(frfs.curves[0], "magnitude");
  const top = magnitude.indexOf(Math.max(...magnitude));
  const at = (i: number) => frfs.freq[Math.min(Math.max(i, 0), frfs.freq.length - 1)];
  return [at(top - LINES_OF_A_CIRCLE), at(top + LINES_OF_A_CIRCLE)];
}

/** Return the plots of the view as one picture, on the colour of the page. */
export function chartImage(): Promise<Blob> {
  const plots = [...document.querySelectorAll<HTMLCanvasElement>(".stack .chart canvas")];
  const whole = document.createElement("canvas");
  whole.width = Math.max(...plots.map((plot) => plot.width));
  whole.height = plots.reduce((sum, plot) => sum + plot.height, 0);
  const context = whole.getContext("2d")!;
  context.fillStyle = getComputedStyle(document.querySelector(".stage")!).backgroundColor;
  context.fillRect(0, 0, whole.width, whole.height);
  let top = 0;
  for (const plot of plots) {
    context.drawImage(plot, 0, top);
    top += plot.height;
  }
  return new Promise((resolve) => whole.toBlob((blob) => resolve(blob!), "image/png"));
}

function ResponseChoice({ names, chosen, set }: { names: string[]; chosen: string[]; set(chosen: string[] | null): void }) {
  const flip = (name: string) => set(chosen.includes(name) ? chosen.filter((other) => other !== name) : names.filter((n) => n === name || chosen.includes(n)));
  return (
    <details class="responses" open={names.length <= 16}>
      <summary>{chosen.length} of {names.length} FRFs</summary>
      <div class="chips">
        <button type="button" class="quiet" onClick={() => set(null)}>All</button>
        <button type="button" class="quiet" onClick={() => set(names.slice(0, 1))}>First only</button>
        {names.slice(0, 200).map((name) => (
          <label class="chip">
            <input type="checkbox" checked={chosen.includes(name)} onChange={() => flip(name)} />
            <span>{name.split(" / ")[0]}</span>
          </label>
        ))}
      </div>
    </details>
  );
}
