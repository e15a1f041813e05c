/** The same work as Python, with the client of the service. */

import type { CatalogueEntry } from "./model";
import { type RigDraft, bodyOf } from "./rig";
import { holder } from "./session";

/** Return a value as Python writes it. */
export function literal(value: unknown): string {
  if (value === null || value === undefined) return "None";
  if (value === true) return "True";
  if (value === false) return "False";
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value === "object") {
    return `{${Object.entries(value as object).map(([name, entry]) => `${literal(name)}: ${literal(entry)}`).join(", ")}}`;
  }
  return JSON.stringify(value);
}

/** Return code with a connection around indented lines; it names the place of a key, never the key. */
export function program(lines: string[], address = origin(), withKey = holder() !== null): string {
  const body = lines.map((line) => (line ? `    ${line}` : "")).join("\n");
  const key = withKey ? "# Your key is read from the environment variable MODALLAB_KEY.\n" : "";
  return `from modallab_client import ModalLab\n\n${key}with ModalLab(${literal(address)}) as lab:\n${body}\n`;
}

/** Return the address of the page without what stands behind it. */
export function origin(): string {
  return new URL(".", location.href).href.replace(/\/$/, "");
}

export function structureLine(name: string, id: string, known: CatalogueEntry[] | null): string {
  return known?.some((entry) => entry.kind === name)
    ? `model = lab.structures.catalogue(${literal(name)})`
    : `model = lab.structures.get(${literal(id)})`;
}

export function rigLines(rig: RigDraft): string[] {
  const fields = Object.entries(bodyOf(rig)).map(([name, value]) => `    ${name}=${literal(value)},`);
  return ["rig = lab.rigs.create(", ...fields, ")"];
}

export interface HiddenEffect {
  kind: string;
  at: unknown;
  parameters: Record<string, number>;
}

export function measureLines(effects: HiddenEffect[], seed: number): string[] {
  const hidden = effects.length ? [`effects = ${literal(effects)}  # in no log book`] : [];
  const also = effects.length ? ", effects=effects" : "";
  return [
    ...hidden,
    `test = lab.measurements.start(model.id, rig.id, seed=${seed}${also}).result()`,
    "print(test.freq.shape, test.values.shape, test.coherence.min())",
  ];
}

/** Return a call with a value for each name, one on each line. */
function call(start: string, named: Record<string, unknown>): string[] {
  const given = Object.entries(named).filter(([, value]) => value !== null && value !== undefined);
  return [`${start}(`, ...given.map(([name, value]) => `    ${name}=${literal(value)},`), ")"];
}

export function assignmentLines({ class_id, title, ...named }: Record<string, unknown>): string[] {
  const [start, ...rest] = call("assignment = lab.assignments.create", named);
  return [start, `    ${literal(class_id)},`, `    ${literal(title)},`, ...rest, "print(assignment.id)"];
}

export function marksLines(assignment: string): string[] {
  return [
    `for row in lab.assignments.marks(${literal(assignment)}):`,
    '    points = row.submission.marks.points if row.submission else "no answer"',
    "    print(row.name, row.measurements, points)",
  ];
}

export function trialLines(assignment: string, { rig, route }: { rig?: unknown; route?: unknown }): string[] {
  const by = route === undefined ? "" : `, route=${literal(route)}`;
  return [
    `test = lab.assignments.measure(${literal(assignment)}, ${literal(rig)}${by}).result()  # one of the tests that are left`,
    "print(test.freq.shape, test.values.shape, test.coherence.min())",
  ];
}

export function answerLines(assignment: string, { effects, coefficients, words }: { effects: unknown[]; coefficients: object; words: string }): string[] {
  return [
    `answer = lab.assignments.submit(${literal(assignment)}, ${literal(effects)}, coefficients=${literal(coefficients)}, words=${literal(words)})`,
    "print(answer.marks.points, answer.marks.maximum)",
  ];
}
