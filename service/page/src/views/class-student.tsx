/** A student's assignment: what is left, the tests within its choices, the answer and its marks. */

import { useCallback, useState } from "preact/hooks";
import { type Assignment, type Limits, assignments, firstOf, isOver, trialOf, valueAt } from "../class";
import { placeText, timeText, words } from "../format";
import { Actions } from "../parts/actions";
import { Group, NumberField, SelectField, StartButton } from "../parts/fields";
import { Empty, Loading, ProblemNote, WorkNote } from "../parts/notes";
import { program, trialLines } from "../python";
import { type State, address, go } from "../state";
import { type Work, usePolled, useWork } from "../use";
import { AnswerForm } from "./answer-form";
import { MarksOf } from "./marks";

export function StudentView({ state }: { state: State }) {
  const given = usePolled("assignments", assignments);
  const current = given.value?.find((one) => one.id === state.a) ?? given.value?.[0];
  const done = useCallback((id: string) => {
    given.again();
    go({ t: [id], s: current!.structure_id, x: undefined, f: [], u: undefined, d: undefined });
  }, [current?.structure_id]);
  const work = useWork(done);
  if (!current) {
    return (
      <section class="stage">
        {given.problem && <ProblemNote problem={given.problem} again={given.again} />}
        {given.loading && <Loading what="the assignments" />}
        {given.value && <Empty title="No assignment yet"><p>Your instructor has set none so far.</p></Empty>}
      </section>
    );
  }
  const left = current.quota - current.measurements.length;
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="class-title">
        <div class="stage-head">
          <h1 id="class-title">{current.title}</h1>
          <p class="facts">{factsOf(current, left)}</p>
        </div>
        <WorkNote work={work} what="test" />
        {given.value!.length > 1 && <div class="toolbar"><SelectField label="Assignment" value={current.id} set={(id) => go({ a: id })} options={given.value!.map((one) => ({ value: one.id, text: one.title }))} /></div>}
        {current.revealed && <p class="notice">{`Hidden was: ${current.revealed.map((effect) => `${words(effect.kind)} ${placeText(effect.at)}`).join(", ") || "nothing"}.`}</p>}
        <Tests assignment={current} state={state} />
        {current.submission && <MarksOf submission={current.submission} />}
        {!isOver(current) && <AnswerForm key={current.id} assignment={current} diagnosisId={state.d} sent={given.again} />}
      </section>
      <aside class="panel" aria-label="Test">
        <Trial key={current.id} assignment={current} left={left} work={work} />
      </aside>
    </div>
  );
}

function factsOf(assignment: Assignment, left: number): string {
  const until = assignment.deadline ? (isOver(assignment) ? `Closed since ${timeText(assignment.deadline)}` : `Until ${timeText(assignment.deadline)}`) : "No deadline";
  const answers = assignment.submissions - (assignment.submission?.number ?? 0);
  return `${left} of ${assignment.quota} tests left, ${answers} of ${assignment.submissions} answers left. ${until}.`;
}

const LINKS = [["measure", "FRFs"], ["extract", "Extract modes"], ["diagnose", "Diagnose"]] as const;

function Tests({ assignment, state }: { assignment: Assignment; state: State }) {
  if (!assignment.measurements.length) return <p class="hint">Something is hidden in the test. Measure, and find out what it is.</p>;
  return (
    <ul class="tests own-tests">
      {assignment.measurements.map((id, i) => (
        <li>
          <span>Test {i + 1}{id === null ? ": not finished, or failed" : ""}</span>
          {id && LINKS.map(([view, text]) => <a href={address({ view, a: state.a, s: assignment.structure_id, t: [id], f: [] })} aria-label={`${text}, test ${i + 1}`}>{text}</a>)}
        </li>
      ))}
    </ul>
  );
}

/** The choices that the assignment allows, and the button that measures. */
function Trial({ assignment, left, work }: { assignment: Assignment; left: number; work: Work }) {
  const entries = Object.entries(assignment.choices);
  const [chosen, setChosen] = useState<Record<string, unknown>>(() => Object.fromEntries(entries.map(([path, limits]) => [path, firstOf(limits, valueAt(assignment.rig, path))])));
  return (
    <Group title="Test">
      {entries.map(([path, limits]) => <ChosenField path={path} limits={limits} value={chosen[path]} set={(value) => setChosen({ ...chosen, [path]: value })} />)}
      {!entries.length && <p class="hint">There is nothing to choose.</p>}
      <StartButton busy={work.busy} disabled={left < 1 || isOver(assignment)} start={() => work.start(`/assignments/${assignment.id}/measurements`, trialOf(chosen))}>{work.busy ? "Measuring …" : left < 1 ? "No tests left" : "Measure"}</StartButton>
      <Actions python={() => program(trialLines(assignment.id, trialOf(chosen)))} />
    </Group>
  );
}

const capital = (text: string) => text.charAt(0).toUpperCase() + text.slice(1);

function ChosenField({ path, limits, value, set }: { path: string; limits: Limits; value: unknown; set(value: unknown): void }) {
  const label = capital(words(path.split(".").at(-1)!));
  if ("between" in limits) {
    const [min, max] = limits.between;
    return <NumberField label={label} value={value as number} set={set} min={min} max={max} whole={Number.isInteger(min) && Number.isInteger(max)} />;
  }
  if (!Array.isArray(value)) {
    return <SelectField label={label} value={String(value)} set={(text) => set(limits.one_of.find((one) => String(one) === text))} options={limits.one_of.map((one) => ({ value: String(one), text: String(one) }))} />;
  }
  const flip = (one: unknown) => set(limits.one_of.filter((other) => (other === one ? !value.includes(one) : value.includes(other))));
  return (
    <fieldset class="chips chosen-list">
      <legend>{label}</legend>
      {limits.one_of.map((one) => (
        <label class="chip">
          <input type="checkbox" checked={value.includes(one)} onChange={() => flip(one)} />
          <span>{String(one)}</span>
        </label>
      ))}
    </fieldset>
  );
}
