/** View 3: modes from the FRFs of a test. */

import { useCallback, useMemo, useState } from "preact/hooks";
import { arrays } from "../api";
import { short } from "../format";
import { type ModalModel, catalogue, modalModel } from "../model";
import { Choice, Group, NumberField, SelectField, StartButton } from "../parts/fields";
import { Empty, Loading, ProblemNote, WorkNote } from "../parts/notes";
import type { Arrays } from "../npz";
import type { Range } from "../plot/chart";
import { FrfStack } from "../plot/frf-stack";
import { literal, program } from "../python";
import { type State, address, go } from "../state";
import { useLoaded, useWork } from "../use";
import { loadTest } from "./measure";
import { FitPanel } from "./fits";
import { ModePanel } from "./modes";
import { StabilisationChart } from "./stabilisation";

type Bands = "auto" | "mine";

const TOGETHER = ["circle_fit", "line_fit", "dobson"];

export function ExtractView({ state }: { state: State }) {
  const test = state.t[0];
  const loaded = useLoaded(test ? `tests/${test}` : null, () => Promise.all([loadTest(test)]));
  const methods = useLoaded("catalogue/extraction-methods", () => catalogue("extraction-methods"));
  const model = useLoaded(state.x ? `modes/${state.x}` : null, () => loadModes(state.x!));
  const others = useLoaded(state.f.length ? `models/${state.f}` : null, () => Promise.all(state.f.map(modalModel)));
  const [chosen, setChosen] = useState(0);
  const [method, setMethod] = useState("");
  const [choice, setChoice] = useState<Bands>("auto");
  const [bands, setBands] = useState<Range[]>([]);
  const [nModes, setNModes] = useState(0);
  const done = useCallback((first: string, ...more: string[]) => {
    setChosen(0);
    go({ x: first, f: more, u: undefined });
  }, []);
  const work = useWork(done);
  const request = {
    measurement_id: test,
    ...(method && { method: method === "together" ? TOGETHER[0] : method }),
    ...(choice === "mine" && bands.length && { bands }),
    ...(nModes > 0 && { n_modes: nModes }),
  };
  const addBand = (band: Range) => {
    setChoice("mine");
    setBands((old) => [...old, band.map((f) => Number(f.toPrecision(5))) as Range].sort((a, b) => a[0] - b[0]));
  };
  const start = () => work.start("/modal-models", ...(method === "together" ? TOGETHER.map((one) => ({ ...request, method: one })) : [request]));
  const found = useMemo(() => (model.value && loaded.value ? fittedBands(model.value.shapes, loaded.value[0].frfs.freq) : []), [model.value, loaded.value]);
  const shaded = choice === "mine" ? bands : found;
  if (!test) return <NoTest state={state} />;
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="extract-title">
        <div class="stage-head">
          <h1 id="extract-title">Modes</h1>
          <p class="facts">{model.value ? factsOf(model.value.model) : "Drag over the plot to mark a band with one mode, or let the bands be found."}</p>
        </div>
        <WorkNote work={work} what="extraction" />
        {model.problem && <ProblemNote problem={model.problem} again={() => go({ x: undefined })} />}
        {model.value && <ModePanel model={model.value.model} shapes={model.value.shapes} structureId={state.s} chosen={chosen} setChosen={setChosen} python={() => pythonOf(request, method === "together" ? TOGETHER : [])} />}
        {model.value?.shapes.fitted_lines && model.value.model.modes[chosen] && (!state.f.length || others.value) && <FitPanel key={state.x} models={[model.value.model, ...(others.value ?? [])]} frequency={model.value.model.modes[chosen].frequency} />}
        {model.value?.shapes.chart_order && <StabilisationChart model={model.value.model} />}
        {loaded.problem && <ProblemNote problem={loaded.problem} />}
        {loaded.loading && <Loading what="the FRFs" />}
        {loaded.value && <FrfStack tests={loaded.value} bands={shaded} onBand={addBand} />}
      </section>
      <aside class="panel" aria-label="Extraction">
        <Group title="Extraction">
          <SelectField label="Method" value={method} set={setMethod} options={[{ value: "", text: "chosen for me" }, { value: "together", text: "circle, line, Dobson" }, ...(methods.value ?? []).map((entry) => ({ value: entry.kind, hint: entry.summary }))]} />
          <p class="hint">{method === "together" ? "Circle fit, line fit and Dobson on the same bands, side by side." : (methods.value?.find((entry) => entry.kind === method)?.summary ?? "By the number of references of the test.")}</p>
          <Choice<Bands> label="Bands" value={choice} set={setChoice} options={[{ value: "auto", text: "Found" }, { value: "mine", text: "Mine" }]} />
          {choice === "auto" && found.length > 0 && <button type="button" class="wide" onClick={() => { setBands(found); setChoice("mine"); }}>Take the {found.length} bands found</button>}
          {choice === "auto" && <NumberField label="Modes at most (0: all)" value={nModes} set={setNModes} min={0} max={500} whole />}
          {choice === "mine" && <BandList bands={bands} setBands={setBands} add={addBand} />}
          <StartButton busy={work.busy} disabled={choice === "mine" && !bands.length} start={start}>{work.busy ? "Extracting …" : "Extract"}</StartButton>
        </Group>
        {model.value && (
          <>
            <Group title="How it was done">
              <dl class="choices">
                {Object.entries(model.value.model.choices).map(([name, words]) => (<><dt>{name.replaceAll("_", " ")}</dt><dd>{words}</dd></>))}
              </dl>
            </Group>
            <a class="next" href={address({ ...state, view: "correlate" })}>Correlate</a>
          </>
        )}
        <a class="next plain" href={address({ ...state, view: "diagnose" })}>Diagnose</a>
      </aside>
    </div>
  );
}

/** Return the band of each mode: the lines that were fitted, of all FRFs together. */
function fittedBands(shapes: Arrays, freq: Float64Array): Range[] {
  if (!shapes.fitted_lines) return [];
  const { values, shape: [nModes, nFrfs] } = shapes.fitted_lines;
  const ends = values as Float64Array;
  return Array.from({ length: nModes }, (_, mode) => {
    const of = Array.from(ends.subarray(2 * mode * nFrfs, 2 * (mode + 1) * nFrfs));
    return [freq[Math.min(...of)], freq[Math.max(...of)]];
  });
}

export async function loadModes(id: string) {
  const [model, shapes] = await Promise.all([modalModel(id), arrays(`/modal-models/${id}/arrays`)]);
  return { model, shapes };
}

function factsOf(model: ModalModel): string {
  const n = model.modes.length;
  if (!n) return "No mode was found.";
  return `${n} ${n > 1 ? "modes" : "mode"} from ${short(model.modes[0].frequency)} to ${short(model.modes[n - 1].frequency)} Hz.`;
}

export function NoTest({ state }: { state: State }) {
  return (
    <section class="stage">
      <Empty title="No test yet">
        <p>This step reads the FRFs of a test.</p>
        <a class="next" href={address({ ...state, view: "measure" })}>Measure</a>
      </Empty>
    </section>
  );
}

/** Return the extraction as Python, by one method or by several. */
function pythonOf({ measurement_id: id, ...options }: Record<string, unknown>, methods: string[]): string {
  const keywords = Object.entries(options).map(([name, value]) => `, ${name}=${methods.length && name === "method" ? "method" : literal(value)}`).join("");
  const lines = [`modes = lab.modal_models.start(${literal(id)}${keywords}).result()`, "print(modes.table())"];
  if (!methods.length) return program(lines);
  return program([`for method in ${literal(methods)}:`, ...lines.map((line) => `    ${line}`)]);
}

function BandList({ bands, setBands, add }: { bands: Range[]; setBands(bands: Range[]): void; add(band: Range): void }) {
  const [low, setLow] = useState(0);
  const [high, setHigh] = useState(0);
  return (
    <div class="bands">
      <ul class="tests">
        {bands.map((band, i) => (
          <li>
            <span>{short(band[0], 5)} – {short(band[1], 5)} Hz</span>
            <button type="button" class="quiet" aria-label={`Remove the band from ${short(band[0], 5)} Hz`} onClick={() => setBands(bands.filter((_, k) => k !== i))}>×</button>
          </li>
        ))}
      </ul>
      <NumberField label="From" unit="Hz" value={low} set={setLow} min={0} />
      <NumberField label="To" unit="Hz" value={high} set={setHigh} min={0} />
      <button type="button" class="wide" disabled={!(high > low)} onClick={() => add([low, high])}>Add the band</button>
    </div>
  );
}
