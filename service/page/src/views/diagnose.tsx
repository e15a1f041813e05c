/** View 5: what the model or the log book lacks to explain a test. */

import { useCallback, useState } from "preact/hooks";
import { arrays } from "../api";
import { placeText, short, words } from "../format";
import { type Diagnosis, diagnosis, structure } from "../model";
import { Actions } from "../parts/actions";
import { DropZone } from "../parts/dropzone";
import { Group, NumberField, SelectField, StartButton } from "../parts/fields";
import { Empty, Loading, ProblemNote, WorkNote, brief } from "../parts/notes";
import { literal, program } from "../python";
import { type State, go } from "../state";
import { useActions, useLoaded, useWork } from "../use";
import type { Range } from "../plot/chart";
import { Comparison } from "./comparison";
import { CandidateTable, GapByStep, RivalTable, StepList } from "./findings";
import { ImportZone } from "./import-zone";
import { factsOf, loadTest } from "./measure";
import { fromFile } from "./structure-panel";
import { UnknownEffect } from "./unknown";

const TOLERANCES = [
  { value: "none", text: "nothing" },
  { value: "careful", text: "careful test" },
  { value: "ordinary", text: "ordinary test" },
  { value: "student", text: "student's test" },
];

export function DiagnoseView({ state }: { state: State }) {
  const test = state.t[0];
  const about = useLoaded(state.s ? `structure/${state.s}` : null, () => structure(state.s!));
  const loaded = useLoaded(test ? `tests/${test}` : null, () => Promise.all([loadTest(test)]));
  const found = useLoaded(state.d ? `diagnosis/${state.d}` : null, () =>
    Promise.all([diagnosis(state.d!), arrays(`/diagnoses/${state.d}/arrays`)]),
  );
  const [tolerances, setTolerances] = useState("none");
  const [most, setMost] = useState(4);
  const work = useWork(useCallback((id: string) => go({ d: id }), []));
  const request = {
    structure_id: state.s,
    measurement_id: test,
    ...(tolerances !== "none" && { tolerances }),
    ...(most !== 4 && { max_effects: most }),
  };
  const ready = state.s !== undefined && test !== undefined;
  const start = (more = {}) => work.start("/diagnoses", { ...request, ...more });
  const goOn = (structureId: string) => {
    go({ s: structureId, d: undefined });
    start({ structure_id: structureId });
  };
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="diagnose-title">
        <div class="stage-head">
          <h1 id="diagnose-title">Diagnosis</h1>
          <p class="facts">What do the model and the log book lack to explain this test?</p>
        </div>
        <WorkNote work={work} what="diagnosis" />
        {found.problem && <ProblemNote problem={found.problem} again={() => go({ d: undefined })} />}
        {found.loading && <Loading what="the diagnosis" />}
        {found.value && <Finding result={found.value[0]} curves={found.value[1]} python={() => pythonOf(request)} next={() => start({ act: true })} goOn={goOn} busy={work.busy} />}
        {!state.d && !work.busy && (
          <Empty title={ready ? "Not diagnosed yet" : "A model and a test are needed"}>
            <p>{ready ? "The test is compared with what the model predicts, and every known effect is tried." : "Measure one in steps 1 and 2, or drop your own files."}</p>
            {ready && <button type="button" class="primary" onClick={() => start()}>Start the diagnosis</button>}
          </Empty>
        )}
      </section>
      <aside class="panel" aria-label="Diagnosis">
        <Group title="Compared">
          <dl class="summary">
            <dt>Model</dt><dd>{about.value ? about.value.name || state.s : "none"}</dd>
            <dt>Test</dt><dd>{loaded.value ? loaded.value[0].name : "none"}</dd>
          </dl>
          {loaded.value && <p class="hint">{factsOf(loaded.value[0].about)}</p>}
          <SelectField label="May differ a little" value={tolerances} set={setTolerances} options={TOLERANCES} />
          <NumberField label="Effects at most" value={most} set={setMost} min={1} max={8} whole />
          <StartButton busy={work.busy} disabled={!ready} start={() => start()}>{work.busy ? "Searching …" : state.d ? "Diagnose again" : "Start the diagnosis"}</StartButton>
        </Group>
        <OwnFiles />
      </aside>
    </div>
  );
}

function OwnFiles() {
  const { run, problem } = useActions();
  const take = (files: File[]) =>
    run(async () => go({ s: (await fromFile(files[0])).id, rig: undefined, d: undefined }));
  return (
    <Group title="Own files">
      <DropZone label="Drop a model here" hint="JSON body, Nastran .bdf, mesh, npz" take={take} />
      {problem && <ProblemNote problem={problem} />}
      <ImportZone taken={(id) => go({ t: [id], x: undefined, u: undefined, d: undefined })} />
    </Group>
  );
}

interface FindingProps {
  result: Diagnosis;
  curves: Parameters<typeof Comparison>[0]["curves"];
  python: () => string;
  next(): void;
  goOn(structureId: string): void;
  busy: boolean;
}

function Finding({ result, curves, python, next, goOn, busy }: FindingProps) {
  return (
    <>
      <p class={`verdict ${result.verdict}`}>{result.headline}</p>
      {result.steps.length > 0 && <StepList steps={result.steps} />}
      {result.follow_ups.length > 0 && <p class="hint">{`Explained together with ${result.follow_ups.map((test) => `a test with ${changeWords(test.changed)}`).join(" and ")}.`}</p>}
      <GapByStep result={result} />
      {result.unknown && <UnknownEffect key={result.id} result={result} unknown={result.unknown} curves={curves} goOn={goOn} />}
      <Comparison curves={curves} located={result.located.bands as Range[]} />
      <RivalTable steps={result.steps} />
      {result.candidates.length > 0 && (
        <details open={!result.steps.length}>
          <summary>What was tried first <span class="count">{result.candidates.length}</span></summary>
          <CandidateTable candidates={result.candidates} />
        </details>
      )}
      {result.next_test && <NextTest test={result.next_test} run={next} busy={busy} />}
      {result.located.words.length > 0 && (
        <details>
          <summary>Where they part</summary>
          <ul class="located">{result.located.words.map((text) => <li>{text}</li>)}</ul>
        </details>
      )}
      {result.notes.map((note) => <p class="hint">{note}</p>)}
      <Actions
        python={python}
        downloads={[
          { text: "npz", name: `${result.id}.npz`, from: `v1/diagnoses/${result.id}/arrays` },
          { text: "Report, HTML", name: `${result.id}.html`, from: `v1/diagnoses/${result.id}/report` },
        ]}
      />
      <p class="hint">
        <a href={`v1/diagnoses/${result.id}/report`} target="_blank" rel="noopener">Open the report</a>, one page to print or to send.
        {result.steps.length > 0 && (
          <>
            {" "}
            <button type="button" class="action" onClick={() => go({ s: result.structure_id, d: undefined })}>Go on with the model that has {result.steps.map((step) => `${words(step.effect.kind)} ${placeText(step.effect.at)}`).join(" and ")}</button>
          </>
        )}
      </p>
    </>
  );
}

function NextTest({ test, run, busy }: { test: NonNullable<Diagnosis["next_test"]>; run(): void; busy: boolean }) {
  const separated = test.separates.map(words).join(" from ");
  return (
    <div class="notice">
      <p>
        <b>Next test.</b> Measure again with {changeWords(test.change)}: {test.why}.
        {separated && ` It tells ${separated}`}
        {separated && test.expected_separation !== null && `, by ${short(test.expected_separation, 2)} standard deviations`}
        {separated && "."}
      </p>
      <button type="button" disabled={busy} onClick={run}>Run it and diagnose again</button>
    </div>
  );
}

function changeWords(change: Record<string, unknown>): string {
  return Object.entries(change).map(([name, value]) => `${words(name)} ${brief(value)}`).join(", ") || "no change";
}

function pythonOf(request: Record<string, unknown>): string {
  const { structure_id: model, measurement_id: test, ...options } = request;
  const keywords = Object.entries(options).map(([name, value]) => `, ${name}=${literal(value)}`).join("");
  return program([
    `found = lab.diagnoses.start(${literal(model)}, ${literal(test)}${keywords}).result()`,
    "print(found.verdict)",
    "for step in found.steps:",
    "    print(step.effect.kind, step.effect.at, step.gap_before, step.gap_after)",
  ]);
}
