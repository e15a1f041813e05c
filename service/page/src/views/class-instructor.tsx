/** An instructor's classes: keys are handed out, assignments made and watched. */

import { useState } from "preact/hooks";
import { file } from "../api";
import { type Assignment, type ClassEntry, assignments, classes, createClass, marksOf, namesOf } from "../class";
import { timeText } from "../format";
import { save } from "../parts/actions";
import { Group, SelectField, TextArea, TextField } from "../parts/fields";
import { Empty, Loading, ProblemNote } from "../parts/notes";
import { type State, go } from "../state";
import { useActions, usePolled } from "../use";
import { AssignmentForm } from "./assignment-form";
import { LinksOf } from "./class-links";
import { MarksTable } from "./marks";
import { WordsOf } from "./words";

const WATCHED = 5000; // ms between two looks at the table

export function InstructorView({ state }: { state: State }) {
  const mine = usePolled("classes", classes);
  const made = usePolled("assignments", assignments);
  const entered = mine.value?.find((one) => one.id === state.c) ?? mine.value?.[0];
  const ofClass = made.value?.filter((one) => one.class_id === entered?.id) ?? [];
  const current = ofClass.find((one) => one.id === state.a) ?? ofClass[0];
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="class-title">
        <div class="stage-head">
          <h1 id="class-title">{entered?.name ?? "Class"}</h1>
        </div>
        {mine.problem && <ProblemNote problem={mine.problem} again={mine.again} />}
        {mine.loading && <Loading what="the classes" />}
        {mine.value && !entered && <Empty title="No class yet"><p>Create one: each name gets a key, which its student signs in with.</p></Empty>}
        {ofClass.length > 1 && current && (
          <div class="toolbar"><SelectField label="Assignment" value={current.id} set={(id) => go({ a: id })} options={ofClass.map((one) => ({ value: one.id, text: one.title }))} /></div>
        )}
        {current && <Watched key={current.id} assignment={current} />}
        {entered && <AssignmentForm key={entered.id} state={state} classId={entered.id} open={!current} made={(assignment) => { made.again(); go({ a: assignment.id }); }} />}
      </section>
      <aside class="panel" aria-label="Classes">
        {mine.value && mine.value.length > 1 && (
          <Group title="Class"><SelectField label="Name" value={entered!.id} set={(id) => go({ c: id, a: undefined })} options={mine.value.map((one) => ({ value: one.id, text: one.name }))} /></Group>
        )}
        {entered && <KeysOf key={entered.id} entered={entered} />}
        {entered && <LinksOf key={`links/${entered.id}`} entered={entered} />}
        <NewClass made={(id) => { mine.again(); go({ c: id, a: undefined }); }} />
      </aside>
    </div>
  );
}

function Watched({ assignment }: { assignment: Assignment }) {
  const rows = usePolled(`marks/${assignment.id}`, () => marksOf(assignment.id), WATCHED);
  return (
    <section class="watched" aria-labelledby="watched-title">
      <h2 id="watched-title">{assignment.title}</h2>
      <p class="hint">{assignment.deadline ? `Until ${timeText(assignment.deadline)}.` : "No deadline."} {assignment.reveal ? `Revealed ${timeText(assignment.reveal)}.` : ""}</p>
      {rows.problem && <ProblemNote problem={rows.problem} again={rows.again} />}
      {rows.value && <MarksTable assignment={assignment} rows={rows.value} />}
      {rows.value && <WordsOf assignment={assignment} rows={rows.value} marked={rows.again} />}
    </section>
  );
}

function NewClass({ made }: { made(id: string): void }) {
  const [name, setName] = useState("");
  const { run, busy, problem } = useActions();
  const create = async () => {
    const entry = await createClass(name.trim());
    setName("");
    made(entry.id);
  };
  return (
    <Group title="New class">
      <TextField label="Name of the class" value={name} set={setName} />
      <button type="button" class="wide" disabled={!name.trim() || busy} onClick={() => run(create)}>Create the class</button>
      {problem && <ProblemNote problem={problem} />}
    </Group>
  );
}

/** Keys are told once: they go into a file and never into the page. */
function KeysOf({ entered }: { entered: ClassEntry }) {
  const [text, setText] = useState("");
  const [keys, setKeys] = useState<Blob | null>(null);
  const [count, setCount] = useState(0);
  const { run, busy, problem } = useActions();
  const names = namesOf(text);
  const handOut = async () => {
    const table = await file(`/classes/${entered.id}/members`, "text/csv", { names });
    setKeys(table);
    setCount(names.length);
    setText("");
    save(table, "keys.csv");
  };
  return (
    <Group title="Keys">
      <TextArea label="Names, one a line" value={text} set={setText} rows={4} />
      <button type="button" class="wide" disabled={!names.length || busy} onClick={() => run(handOut)}>{names.length === 1 ? "Make 1 key" : `Make ${names.length || ""} keys`}</button>
      {keys && (
        <>
          <p class="hint" role="status">{count === 1 ? "The key is in keys.csv. It is told once" : `${count} keys are in keys.csv. They are told once`}: keep the file.</p>
          <button type="button" class="wide" onClick={() => save(keys, "keys.csv")}>Save keys.csv again</button>
        </>
      )}
      {problem && <ProblemNote problem={problem} />}
    </Group>
  );
}
