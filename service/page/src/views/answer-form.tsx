/** A student's answer: effects with place and size, coefficients, words. */

import { useState } from "preact/hooks";
import { post } from "../api";
import { type Assignment, type NamedEffect, type PlaceKind, placeOf, placeText } from "../class";
import { words } from "../format";
import { HIDDEN_ROWS } from "../hidden";
import { type CatalogueEntry, catalogue, diagnosis } from "../model";
import { Actions } from "../parts/actions";
import { AddField, Group, NumberField, SelectField, TextArea, TextField } from "../parts/fields";
import { ProblemNote } from "../parts/notes";
import { answerLines, program } from "../python";
import { useActions, useLoaded } from "../use";

interface Draft {
  kind: string;
  place: PlaceKind;
  text: string;
  parameters: Record<string, number>;
}

const PLACES: { value: PlaceKind; text: string }[] = [
  { value: "dof", text: "a point" },
  { value: "members", text: "members" },
  { value: "channels", text: "channels" },
  { value: "everywhere", text: "everywhere" },
];

export function AnswerForm({ assignment, diagnosisId, sent }: { assignment: Assignment; diagnosisId?: string; sent(): void }) {
  const entries = useLoaded("catalogue/effects", () => catalogue("effects"));
  const found = useLoaded(diagnosisId ? `found/${diagnosisId}` : null, () => diagnosis(diagnosisId!));
  const [effects, setEffects] = useState<Draft[]>([]);
  const [coefficients, setCoefficients] = useState<Record<string, number>>(() => Object.fromEntries(assignment.rubric.names.map((name) => [name, 1])));
  const [text, setText] = useState("");
  const { run, busy, problem } = useActions(undefined, sent);
  const left = assignment.submissions - (assignment.submission?.number ?? 0);
  if (left < 1 || !entries.value) return null;
  const add = (kind: string) => setEffects([...effects, draftOf(entries.value!.find((entry) => entry.kind === kind)!)]);
  const answer = () => ({ effects: effects.map(effectOf), coefficients, words: text });
  const send = () => post(`/assignments/${assignment.id}/submissions`, answer());
  return (
    <section class="answer" aria-labelledby="answer-title">
      <h2 id="answer-title">Answer</h2>
      <p class="hint">What does the test have that the log book does not tell?</p>
      <div class="form-groups">
        {effects.map((draft, i) => (
          <EffectFields
            draft={draft}
            entry={entries.value!.find((entry) => entry.kind === draft.kind)!}
            set={(next) => setEffects(effects.map((old, k) => (k === i ? next : old)))}
            remove={() => setEffects(effects.filter((_, k) => k !== i))}
          />
        ))}
        <Group title="Another effect">
          <AddField label="Effect" add={add} options={entries.value.map((entry) => ({ value: entry.kind, hint: entry.summary }))} />
          {found.value && found.value.steps.length > 0 && <button type="button" class="wide" onClick={() => setEffects(found.value!.steps.map((step) => draftFrom(step.effect)))}>Take over what the diagnosis found</button>}
        </Group>
        {assignment.rubric.names.length > 0 && (
          <Group title="Coefficients">
            {assignment.rubric.names.map((name) => <NumberField label={name} value={coefficients[name]} set={(value) => setCoefficients({ ...coefficients, [name]: value })} />)}
          </Group>
        )}
        <Group title="Words"><TextArea label="Reasons, for your instructor" value={text} set={setText} rows={3} /></Group>
      </div>
      {problem && <ProblemNote problem={problem} />}
      <button type="button" class="primary" disabled={busy} onClick={() => run(send)}>{left > 1 ? `Submit, ${left} answers left` : "Submit, the last answer"}</button>
      <Actions python={() => program(answerLines(assignment.id, answer()))} />
    </section>
  );
}

function EffectFields({ draft, entry, set, remove }: { draft: Draft; entry: CatalogueEntry; set(next: Draft): void; remove(): void }) {
  return (
    <Group title={words(draft.kind)}>
      <SelectField label="Place" value={draft.place} set={(place) => set({ ...draft, place: place as PlaceKind })} options={PLACES} />
      {draft.place !== "everywhere" && <TextField label={draft.place === "members" ? "Members" : draft.place === "channels" ? "Channels" : "Point"} value={draft.text} set={(text) => set({ ...draft, text })} />}
      {Object.entries(draft.parameters).map(([name, value]) => (
        <NumberField
          label={words(name)}
          unit={entry.parameters[name]?.unit.replace(/^1$/, "")}
          value={value}
          min={entry.parameters[name]?.lower}
          max={entry.parameters[name]?.upper}
          set={(next) => set({ ...draft, parameters: { ...draft.parameters, [name]: next } })}
        />
      ))}
      <button type="button" class="quiet" onClick={remove}>Remove {words(draft.kind)}</button>
    </Group>
  );
}

function draftOf(entry: CatalogueEntry): Draft {
  const usual = HIDDEN_ROWS.find((row) => row.kind === entry.kind);
  const place = usual?.place === "channel" ? "channels" : usual?.place === "members" || usual?.place === "everywhere" ? usual.place : "dof";
  const parameters = Object.fromEntries(Object.entries(entry.parameters).map(([name, { absent, lower }]) => [name, usual?.parameters[name] ?? absent ?? lower]));
  return { kind: entry.kind, place, text: "", parameters };
}

function draftFrom({ kind, at, parameters }: { kind: string; at: NamedEffect["at"]; parameters: Record<string, { value: number }> }): Draft {
  const [place, text] = placeText(at);
  return { kind, place, text, parameters: Object.fromEntries(Object.entries(parameters).map(([name, { value }]) => [name, value])) };
}

function effectOf({ kind, place, text, parameters }: Draft): NamedEffect {
  return { kind, at: placeOf(place, text), parameters };
}
