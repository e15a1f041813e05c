/** The form of an assignment: what is under test, what is hidden, what students may choose, how it is marked. */

import { useState } from "preact/hooks";
import { post } from "../api";
import { type Assignment, type HiddenDraft, type Limits, hiddenOf, listOf } from "../class";
import { words } from "../format";
import { HIDDEN_ROWS } from "../hidden";
import { geometry, structure, structureModes } from "../model";
import { Actions } from "../parts/actions";
import { AddField, CheckField, Group, NumberField, SelectField, TextField } from "../parts/fields";
import { ProblemNote } from "../parts/notes";
import { assignmentLines, program } from "../python";
import { type RigDraft, bodyOf, unpacked, usualRig } from "../rig";
import { type State, address } from "../state";
import { useActions, useLoaded } from "../use";

interface FormProps {
  state: State;
  classId: string;
  open: boolean;
  made(assignment: Assignment): void;
}

export function AssignmentForm({ state, classId, open, made }: FormProps) {
  const found = useLoaded(state.s ? `rig/${state.s}` : null, () => Promise.all([structure(state.s!), geometry(state.s!), structureModes(state.s!)]));
  const rig = found.value && unpacked(state.rig, usualRig(found.value[1].dofs, found.value[2].frequencies));
  return (
    <details class="assignment-form" open={open}>
      <summary>New assignment</summary>
      {rig && found.value ? (
        <Fields name={found.value[0].name || "the model"} rig={rig} request={{ class_id: classId, structure: state.s! }} made={made} />
      ) : (
        <p class="hint">An assignment begins with a structure and a rig: <a href={address({ ...state, view: "rig" })}>set them up in step 1</a>.</p>
      )}
    </details>
  );
}

interface FieldsProps {
  name: string;
  rig: RigDraft;
  request: { class_id: string; structure: string };
  made(assignment: Assignment): void;
}

const NUMBERS = { quota: 5, submissions: 1 };
const POINTS = { kind: 2, place: 2, size: 1, words: 0 };

function Fields({ name, rig, request, made }: FieldsProps) {
  const [title, setTitle] = useState("Find the missing effect");
  const [hidden, setHidden] = useState<HiddenDraft[]>([draftOf("extra_mass", rig)]);
  const [choices, setChoices] = useState<Record<string, Limits>>({ "analyser.averages": { between: [5, 100] } });
  const [numbers, setNumbers] = useState(NUMBERS);
  const [points, setPoints] = useState(POINTS);
  const [tolerance, setTolerance] = useState(20);
  const [diagnosis, setDiagnosis] = useState("off");
  const [times, setTimes] = useState({ deadline: "", reveal: "" });
  const { run, busy, problem } = useActions();
  const time = (text: string) => (text ? new Date(text).toISOString() : null);
  const body = () => ({
    ...request, title, choices, diagnosis, ...numbers,
    rig: bodyOf(rig),
    hidden: hidden.map((draft) => hiddenOf(draft, rig.drive)),
    deadline: time(times.deadline),
    reveal: time(times.reveal),
    rubric: { ...points, tolerance: tolerance / 100 },
  });
  const create = async () => made(await post<Assignment>("/assignments", body()));
  return (
    <>
      <div class="form-groups">
        <Group title="Test">
          <TextField label="Title" value={title} set={setTitle} />
          <p class="hint">{`${name}, driven at ${rig.drive}, ${rig.responses.length} responses, ${rig.nLines} lines to ${rig.frequencyMax} Hz: as set up in step 1.`}</p>
          {(Object.keys(NUMBERS) as (keyof typeof NUMBERS)[]).map((key) => <NumberField label={key === "quota" ? "Tests of each student" : "Answers of each student"} value={numbers[key]} set={(value) => setNumbers({ ...numbers, [key]: value })} min={1} max={100} whole />)}
          <SelectField label="Diagnosis" value={diagnosis} set={setDiagnosis} options={[{ value: "off", text: "not allowed" }, { value: "on", text: "allowed" }, { value: "after_deadline", text: "after the deadline" }]} />
          <TextField label="Deadline" kind="datetime-local" value={times.deadline} set={(deadline) => setTimes({ ...times, deadline })} />
          <TextField label="Effects revealed from" kind="datetime-local" value={times.reveal} set={(reveal) => setTimes({ ...times, reveal })} />
        </Group>
        <Group title="Hidden, drawn for each student">
          {hidden.map((draft, i) => <HiddenFields draft={draft} set={(next) => setHidden(hidden.map((old, k) => (k === i ? next : old)))} remove={() => setHidden(hidden.filter((_, k) => k !== i))} />)}
          <AddField label="Another effect" add={(kind) => setHidden([...hidden, draftOf(kind, rig)])} options={HIDDEN_ROWS.filter((row) => !hidden.some((draft) => draft.row.kind === row.kind)).map((row) => ({ value: row.kind }))} />
        </Group>
        <ChoiceFields rig={rig} choices={choices} set={setChoices} />
        <Group title="Points">
          {(Object.keys(POINTS) as (keyof typeof POINTS)[]).map((key) => <NumberField label={`Points for ${key === "kind" ? "kinds" : key === "place" ? "places" : key === "size" ? "sizes" : "words"}`} value={points[key]} set={(value) => setPoints({ ...points, [key]: value })} min={0} max={100} />)}
          <NumberField label="A size is right within" unit="%" value={tolerance} set={setTolerance} min={0} max={100} />
        </Group>
        {problem && <ProblemNote problem={problem} />}
        <button type="button" class="primary" disabled={!title.trim() || busy} onClick={() => run(create)}>Hand out the assignment</button>
      </div>
      <Actions python={() => program(assignmentLines(body()))} />
    </>
  );
}

/** Return an effect with limits around its usual size, at places that the rig measures. */
function draftOf(kind: string, rig: RigDraft): HiddenDraft {
  const row = HIDDEN_ROWS.find((one) => one.kind === kind)!;
  const inner = rig.responses.filter((dof) => dof !== rig.drive);
  const places = row.place === "members" ? "3, 5, 7" : inner.slice(Math.floor(inner.length / 4), Math.ceil((3 * inner.length) / 4)).join(", ");
  const limits = Object.fromEntries(Object.entries(row.parameters).map(([name, value]) => [name, value > 1 && name === "factor" ? [value, value] : [value / 2, 2 * value]]));
  return { row, places, limits: limits as HiddenDraft["limits"] };
}

function HiddenFields({ draft, set, remove }: { draft: HiddenDraft; set(next: HiddenDraft): void; remove(): void }) {
  const { row, places, limits } = draft;
  const limit = (name: string, end: 0 | 1, value: number) => {
    const pair: [number, number] = [...limits[name]];
    pair[end] = value;
    set({ ...draft, limits: { ...limits, [name]: pair } });
  };
  return (
    <fieldset class="sub-group">
      <legend>{words(row.kind)}</legend>
      {!["everywhere", "drive"].includes(row.place) && <TextField label={row.place === "members" ? "One of the members" : row.place === "channel" ? "One of the channels" : "One of the points"} value={places} set={(text) => set({ ...draft, places: text })} />}
      {Object.keys(limits).map((name) => (
        <>
          <NumberField label={`${words(name)} from`} value={limits[name][0]} set={(value) => limit(name, 0, value)} />
          <NumberField label={`${words(name)} to`} value={limits[name][1]} set={(value) => limit(name, 1, value)} />
        </>
      ))}
      <button type="button" class="quiet" onClick={remove}>Remove {words(row.kind)}</button>
    </fieldset>
  );
}

const WINDOWS = ["rectangular", "hann", "flat_top"];

function ChoiceFields({ rig, choices, set }: { rig: RigDraft; choices: Record<string, Limits>; set(choices: Record<string, Limits>): void }) {
  const offered: Record<string, { label: string; usual: Limits }> = {
    "analyser.averages": { label: "Averages", usual: { between: [5, 100] } },
    "analyser.window": { label: "Window", usual: { one_of: WINDOWS } },
    drive: { label: "Drive", usual: { one_of: rig.responses.slice(0, 1).concat(rig.responses.slice(-1)) } },
    responses: { label: "Responses", usual: { one_of: rig.responses } },
  };
  const flip = (path: string) => {
    const { [path]: old, ...others } = choices;
    set(old ? others : { ...choices, [path]: offered[path].usual });
  };
  return (
    <Group title="Students choose">
      {Object.entries(offered).map(([path, { label }]) => {
        const limits = choices[path];
        return (
          <>
            <CheckField label={label} checked={limits !== undefined} flip={() => flip(path)} />
            {limits && "between" in limits && ([0, 1] as const).map((end) => <NumberField label={`${label} ${end ? "to" : "from"}`} value={limits.between[end]} set={(value) => set({ ...choices, [path]: { between: end ? [limits.between[0], value] : [value, limits.between[1]] } })} min={1} whole />)}
            {limits && "one_of" in limits && <TextField label={`${label}: one of`} value={limits.one_of.join(", ")} set={(text) => set({ ...choices, [path]: { one_of: listOf(text) } })} />}
          </>
        );
      })}
    </Group>
  );
}
