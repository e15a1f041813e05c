/** View 2: the test runs, and its FRFs. */

import { useCallback, useState } from "preact/hooks";
import { post } from "../api";
import { keptEstimates, keptRecords } from "../averaging";
import { words } from "../format";
import { hiddenEffects } from "../hidden";
import { type Measurement, catalogue, frfs, geometry, measurement, structure, structureModes } from "../model";
import { Group, NumberField, StartButton } from "../parts/fields";
import { Empty, Loading, ProblemNote, WorkNote } from "../parts/notes";
import { FrfStack, type Test } from "../plot/frf-stack";
import { literal, measureLines, program, rigLines, structureLine } from "../python";
import { type RigDraft, bodyOf, unpacked, usualRig } from "../rig";
import { type State, address, go } from "../state";
import { useLoaded, useWork } from "../use";
import { AveragesNote } from "./averages";
import { AveragingBar, useAveraging, useStep } from "./averaging";
import { ImportZone } from "./import-zone";
import { SignalPanel } from "./signals";

const MOST_TESTS = 6; // in one plot

export function MeasureView({ state }: { state: State }) {
  const [seed, setSeed] = useState(1);
  const [fresh, setFresh] = useState<string | null>(null);
  const done = useCallback(
    (id: string) => {
      setFresh(id);
      setSeed((n) => n + 1);
      go({ t: [id, ...state.t].slice(0, MOST_TESTS), x: undefined, u: undefined, d: undefined });
    },
    [state.t],
  );
  const work = useWork(done);
  const found = useLoaded(state.s ? `rig/${state.s}` : null, () =>
    Promise.all([structure(state.s!), geometry(state.s!), structureModes(state.s!)]),
  );
  const known = useLoaded("catalogue/structures", () => catalogue("structures"));
  const tests = useLoaded(state.t.length ? `tests/${state.t}` : null, () => Promise.all(state.t.map(loadTest)));
  const averaging = useAveraging(tests.value?.[0], fresh);
  const shown = useStep(tests.value, averaging);
  const rig = found.value && unpacked(state.rig, usualRig(found.value[1].dofs, found.value[2].frequencies));
  const effects = hiddenEffects();
  const start = () =>
    work.start("/measurements", async () => {
      const declared = await post<{ id: string }>("/rigs", bodyOf(rig!));
      return { structure_id: state.s, rig_id: declared.id, effects, seed, records: keptRecords(rig!), estimates: keptEstimates(rig!) };
    });
  const python = () =>
    rig && found.value
      ? program([structureLine(found.value[0].name, state.s!, known.value), ...rigLines(rig), ...measureLines(effects, Math.max(1, seed - 1))])
      : program([`test = lab.measurements.get(${literal(state.t[0])})`, "print(test.freq.shape, test.values.shape)"]);
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="measure-title">
        <div class="stage-head">
          <h1 id="measure-title">Frequency responses</h1>
          {tests.value && <p class="facts">{factsOf(tests.value[0].about)}</p>}
        </div>
        <WorkNote work={work} what="test" />
        {work.busy && <AveragesNote message={work.job?.message} />}
        {tests.problem && <ProblemNote problem={tests.problem} again={() => go({ t: [] })} />}
        {(tests.loading || averaging.waiting) && <Loading what="the FRFs" />}
        {averaging.problem && <ProblemNote problem={averaging.problem} />}
        {tests.value && shown && !averaging.waiting && (
          <FrfStack tests={shown} python={python} whole={tests.value[0].frfs} under={<AveragingBar averaging={averaging} about={tests.value[0].about} />} />
        )}
        {tests.value && <SignalPanel key={tests.value[0].id} test={tests.value[0].about} />}
        {!state.t.length && !work.busy && (
          <Empty title="No test yet">
            <p>{rig ? `${rig.responses.length} accelerometers, driven at ${rig.drive}. Start the test, or drop the files of another one.` : "Set up a rig first, or drop the files of a test."}</p>
          </Empty>
        )}
        {tests.value?.[0].about.notes.map((note) => <p class="notice">{note}</p>)}
      </section>
      <aside class="panel" aria-label="Test">
        <Group title="Test">
          {rig && <RigSummary rig={rig} effects={effects.length} />}
          <NumberField label="Seed of the noise" value={seed} set={setSeed} min={0} max={2 ** 31} whole />
          <StartButton busy={work.busy} disabled={!rig} start={start}>{work.busy ? "Measuring …" : state.t.length ? "Measure again" : "Start the test"}</StartButton>
        </Group>
        {tests.value && <TestList tests={tests.value} state={state} />}
        <Group title="Own files"><ImportZone taken={done} /></Group>
        {tests.value && <a class="next" href={address({ ...state, view: "extract" })}>Extract modes</a>}
      </aside>
    </div>
  );
}

export interface LoadedTest extends Test {
  about: Measurement;
}

export async function loadTest(id: string): Promise<LoadedTest> {
  const [about, curves] = await Promise.all([measurement(id), frfs(id)]);
  return { id, name: about.created.slice(11, 19), frfs: curves, about };
}

export function factsOf(about: Measurement): string {
  const { analyser } = about.rig;
  const averages = about.averages ? `${about.averages} averages` : "averages unknown";
  return `${about.outputs.length} responses, ${about.n_lines} lines to ${about.frequency_max} Hz, ${averages}, ${analyser.estimator.toUpperCase()}, ${words(analyser.window)} window.`;
}

function RigSummary({ rig, effects }: { rig: RigDraft; effects: number }) {
  return (
    <dl class="summary">
      <dt>Drive</dt><dd>{rig.drive}, {rig.exciter}</dd>
      <dt>Responses</dt><dd>{rig.responses.length}</dd>
      <dt>Range</dt><dd>{rig.frequencyMax} Hz, {rig.nLines} lines</dd>
      <dt>Hidden</dt><dd>{effects ? `${effects} ${effects > 1 ? "effects" : "effect"}` : "nothing"}</dd>
    </dl>
  );
}

function TestList({ tests, state }: { tests: LoadedTest[]; state: State }) {
  return (
    <Group title="In the plot">
      <ul class="tests">
        {tests.map((test, i) => (
          <li>
            <span>{test.name}{i === 0 ? ", current" : ""}</span>
            {i > 0 && <button type="button" class="quiet" onClick={() => go({ t: [test.id, ...state.t.filter((id) => id !== test.id)], x: undefined, u: undefined, d: undefined })}>Make current</button>}
            {tests.length > 1 && <button type="button" class="quiet" aria-label={`Remove the test of ${test.name}`} onClick={() => go({ t: state.t.filter((id) => id !== test.id) })}>×</button>}
          </li>
        ))}
      </ul>
    </Group>
  );
}
