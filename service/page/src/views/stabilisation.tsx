/** Stabilisation chart of a global method: poles at rising orders; clicked poles choose the modes. */

import { useMemo, useRef, useState } from "preact/hooks";
import { post } from "../api";
import { short } from "../format";
import { type Chart, type ModalModel, stabilisation } from "../model";
import { Actions, csv, svgFile } from "../parts/actions";
import { Loading, ProblemNote } from "../parts/notes";
import type { Range } from "../plot/chart";
import { ticks } from "../plot/figure";
import { ZoomBar } from "../plot/zoom";
import { literal, program } from "../python";
import { go } from "../state";
import { useActions, useLoaded } from "../use";

const [LEFT, RIGHT, TOP, BOTTOM] = [44, 988, 10, 276];
const STABILITIES = ["new", "stable in frequency", "stable in damping too", "stable in shape too"];

export function StabilisationChart({ model }: { model: ModalModel }) {
  const loaded = useLoaded(`chart/${model.id}`, () => stabilisation(model.id));
  if (loaded.problem) return <ProblemNote problem={loaded.problem} />;
  return loaded.value ? <Poles key={model.id} chart={loaded.value} model={model} /> : <Loading what="the stabilisation chart" />;
}

function Poles({ chart, model }: { chart: Chart; model: ModalModel }) {
  const svg = useRef<SVGSVGElement>(null);
  const all = chart.modes.map((_, i) => i + 1);
  const [kept, setKept] = useState(all);
  const [range, setRange] = useState<Range | null>(null);
  const [pole, setPole] = useState<number | null>(null);
  const { run, busy, problem } = useActions();
  const freq = useMemo(() => Float64Array.from(chart.indicators.freq), [chart]);
  const flip = (mode: number) => setKept((old) => (old.includes(mode) ? old.filter((one) => one !== mode) : [...old, mode]));
  const pick = (index: number) => {
    setPole(index);
    const mode = chart.mode[index];
    if (mode !== null) flip(mode);
  };
  const drop = all.filter((mode) => !kept.includes(mode));
  const keep = async () => go({ x: (await post<{ id: string }>(`/modal-models/${model.id}/select`, { drop })).id, f: [], u: undefined });
  return (
    <section class="stabilisation" aria-labelledby="stabilisation-title">
      <div class="toolbar">
        <h2 id="stabilisation-title">Stabilisation chart</h2>
        <ZoomBar freq={freq} range={range} setRange={setRange} />
      </div>
      <div class="drawing" tabIndex={0} role="region" aria-label="Drawing of the stabilisation chart">
        <Drawing svgRef={svg} chart={chart} kept={kept} window={range ?? [freq[0], freq[freq.length - 1]]} pick={pick} />
      </div>
      <p class="readout" aria-live="polite">{pole === null ? "Click a pole to leave its mode out, and again to take it in." : poleWords(chart, pole)}</p>
      <div class="chips" role="group" aria-label="Modes to keep">
        <button type="button" class="quiet" onClick={() => setKept(all)}>All</button>
        <button type="button" class="quiet" onClick={() => setKept([])}>None</button>
        {all.map((mode) => (
          <label class="chip">
            <input type="checkbox" checked={kept.includes(mode)} onChange={() => flip(mode)} />
            <span>{mode}: {short(chart.modes[mode - 1], 5)} Hz</span>
          </label>
        ))}
        <button type="button" disabled={!drop.length || !kept.length || busy} onClick={() => run(keep)}>Keep {kept.length} of {all.length} modes</button>
      </div>
      {problem && <ProblemNote problem={problem} />}
      <Doubtful poles={chart.doubtful} />
      <Actions
        python={() => program([`chosen = lab.modal_models.select(${literal(model.id)}, drop=${literal(drop)})`, "print(chosen.table())"])}
        downloads={[
          { text: "CSV", name: "poles.csv", from: () => csv({ order: chart.order, "frequency, Hz": chart.frequency, "loss factor": chart.loss_factor, stability: chart.stability.map((level) => STABILITIES[level]), mode: chart.mode }) },
          { text: "SVG", name: "stabilisation.svg", from: () => svgFile(svg.current!) },
        ]}
      />
    </section>
  );
}

function poleWords(chart: Chart, index: number): string {
  const mode = chart.mode[index];
  const belongs = mode === null ? "it belongs to no mode" : `of mode ${mode}`;
  return `Pole at ${short(chart.frequency[index], 6)} Hz, loss factor ${short(chart.loss_factor[index])}, order ${chart.order[index]}, ${STABILITIES[chart.stability[index]]}; ${belongs}.`;
}

function Doubtful({ poles }: { poles: Chart["doubtful"] }) {
  if (!poles.length) return null;
  return (
    <details>
      <summary>Poles that are doubtful <span class="count">{poles.length}</span></summary>
      <ul class="located">{poles.map((pole) => <li>{short(pole.frequency, 6)} Hz: {pole.reason}</li>)}</ul>
    </details>
  );
}

interface DrawingProps {
  chart: Chart;
  kept: number[];
  window: Range;
  pick(index: number): void;
  svgRef: { current: SVGSVGElement | null };
}

function Drawing({ chart, kept, window: [low, high], pick, svgRef }: DrawingProps) {
  const most = Math.max(...chart.order);
  const least = Math.min(...chart.order);
  const x = (freq: number) => LEFT + ((freq - low) / (high - low)) * (RIGHT - LEFT);
  const y = (order: number) => BOTTOM - 8 - ((order - least) / Math.max(1, most - least)) * (BOTTOM - TOP - 16);
  const inside = (freq: number) => freq >= low && freq <= high;
  return (
    <svg ref={svgRef} class="poles" viewBox="0 0 1000 322" role="img" aria-label={`Stabilisation chart of ${chart.order.length} poles to order ${most}, with the mode indicator behind`}>
      <g class="figure-axis">
        {ticks([least, most], 6).filter(Number.isInteger).map((order) => (<g><path d={`M${LEFT} ${y(order)}H${RIGHT}`} /><text class="end" x={LEFT - 6} y={y(order) + 4}>{order}</text></g>))}
        {ticks([low, high], 8).map((freq, i, { length }) => <text class={i === length - 1 ? "end" : ""} x={x(freq)} y={BOTTOM + 18}>{`${freq}${i === length - 1 ? " Hz" : ""}`}</text>)}
        <text transform="translate(11 143) rotate(-90)">order</text>
      </g>
      {chart.indicators.cmif.map((values) => <path class="cmif" d={indicatorPath(chart.indicators.freq, values, x, inside)} />)}
      {chart.modes.map((freq, i) => inside(freq) && <path class={kept.includes(i + 1) ? "mode-line kept" : "mode-line"} d={`M${x(freq)} ${TOP}V${BOTTOM}`} />)}
      {chart.frequency.map((freq, i) => {
        if (!inside(freq)) return null;
        const mode = chart.mode[i];
        const dropped = mode !== null && !kept.includes(mode);
        return (
          <g class={`pole stability-${chart.stability[i]}${dropped ? " dropped" : ""}`} data-mode={mode ?? ""} onClick={() => pick(i)}>
            <circle class="target" cx={x(freq).toFixed(1)} cy={y(chart.order[i]).toFixed(1)} r="8" />
            <circle class="mark" cx={x(freq).toFixed(1)} cy={y(chart.order[i]).toFixed(1)} r={chart.stability[i] ? 3.4 : 2} />
          </g>
        );
      })}
      <Legend />
    </svg>
  );
}

function Legend() {
  return (
    <g class="pole-legend">
      {STABILITIES.map((words, level) => (
        <g class={`pole stability-${level}`} transform={`translate(${LEFT + 6 + level * 205} 312)`}>
          <circle class="mark" r={level ? 3.4 : 2} />
          <text x="10" y="4">{words}</text>
        </g>
      ))}
    </g>
  );
}

/** Return the curve of a mode indicator, on a logarithmic scale of its own. */
function indicatorPath(freq: number[], values: number[], x: (freq: number) => number, inside: (freq: number) => boolean): string {
  const points = freq.map((f, i) => [f, values[i]]).filter(([f, value]) => inside(f) && value > 0);
  if (!points.length) return "";
  const levels = points.map(([, value]) => Math.log10(value));
  const [low, high] = [Math.min(...levels), Math.max(...levels)];
  return `M${points.map(([f], i) => `${x(f).toFixed(1)} ${(BOTTOM - ((levels[i] - low) / (high - low || 1)) * (BOTTOM - TOP)).toFixed(1)}`).join("L")}`;
}
