/** Classes and assignments: what the service answers, and the requests that make them. */

import { get, post, put } from "./api";
import type { Place } from "./format";
import type { HiddenRow } from "./hidden";

export interface ClassEntry {
  id: string;
  name: string;
  expires: string | null;
}

export type Limits = { between: [number, number] } | { one_of: (string | number | boolean)[] };

export interface NamedEffect {
  kind: string;
  at: Place;
  parameters: Record<string, number>;
}

export interface Mark {
  criterion: string;
  points: number | null;
  maximum: number;
  reasons: string[];
}

export interface Submission {
  number: number;
  created: string;
  effects: NamedEffect[];
  words: string;
  marks: { points: number; maximum: number; marks: Mark[] };
}

export interface Assignment {
  id: string;
  class_id: string;
  title: string;
  structure_id: string;
  rig: Record<string, unknown>;
  choices: Record<string, Limits>;
  quota: number;
  submissions: number;
  diagnosis: "off" | "on" | "after_deadline";
  deadline: string | null;
  reveal: string | null;
  rubric: { kind: number; place: number; size: number; tolerance: number; coefficients: number; words: number; names: string[] };
  measurements: (string | null)[];
  submission: Submission | null;
  revealed?: NamedEffect[];
}

export interface StudentMarks {
  student: string;
  name: string;
  measurements: number;
  submission: Submission | null;
}

export const classes = async () => (await get<{ items: ClassEntry[] }>("/classes")).items;
export const assignments = async () => (await get<{ items: Assignment[] }>("/assignments")).items;
export const marksOf = async (id: string) => (await get<{ items: StudentMarks[] }>(`/assignments/${id}/marks`)).items;
export const gradeWords = (assignment: string, student: string, points: number, comment: string) =>
  put<Submission>(`/assignments/${assignment}/marks/${student}/words`, { points, comment });
export const createClass = (name: string) => post<ClassEntry>("/classes", { name });

/** Return the names of a list with one on each line, each once. */
export function namesOf(text: string): string[] {
  return [...new Set(text.split("\n").map((name) => name.trim()).filter(Boolean))];
}

/** Return the parts of a list that commas or spaces separate. */
export const listOf = (text: string): string[] => text.split(/[\s,;]+/).filter(Boolean);

export type PlaceKind = "dof" | "members" | "channels" | "everywhere";

/** Return a place from the kind of place and a list of DoFs or members. */
export function placeOf(kind: PlaceKind, text: string): Place {
  const parts = listOf(text);
  if (kind === "everywhere" || !parts.length) return null;
  if (kind === "members") return { members: parts.map(Number) };
  return kind === "channels" ? { channels: parts } : parts[0];
}

/** Return the kind of a place, and its list as text. */
export function placeText(at: Place): [PlaceKind, string] {
  if (at === null) return ["everywhere", ""];
  if (typeof at === "string") return ["dof", at];
  if ("members" in at) return ["members", at.members.join(", ")];
  return "channels" in at ? ["channels", at.channels.join(", ")] : ["dof", at.dofs.join(", ")];
}

/** A hidden effect as it is set up: places of which one is drawn, and limits of each parameter. */
export interface HiddenDraft {
  row: HiddenRow;
  places: string;
  limits: Record<string, [number, number]>;
}

/** Return a hidden effect as the service takes it; a place or number that is not drawn stands alone. */
export function hiddenOf({ row, places, limits }: HiddenDraft, drive: string): Record<string, unknown> {
  const parts = row.place === "drive" ? [drive] : row.place === "everywhere" ? [] : listOf(places);
  const kind = row.place === "members" ? "members" : row.place === "channel" ? "channels" : "dof";
  const all = parts.map((part) => placeOf(kind, part));
  const at = all.length > 1 ? { one_of: all } : (all[0] ?? null);
  const parameters = Object.fromEntries(Object.entries(limits).map(([name, [low, high]]) => [name, low === high ? low : { between: [low, high] }]));
  return { kind: row.kind, at, parameters };
}

/** Return what stands at a path written with dots. */
export function valueAt(tree: unknown, path: string): unknown {
  return path.split(".").reduce<unknown>((inner, name) => (inner && typeof inner === "object" ? (inner as Record<string, unknown>)[name] : undefined), tree);
}

/** Return the body of a measurement: chosen fields by their paths, `route` beside the rig. */
export function trialOf(chosen: Record<string, unknown>): Record<string, unknown> {
  const rig: Record<string, unknown> = {};
  for (const [path, value] of Object.entries(chosen)) {
    if (path === "route") continue;
    const parts = path.split(".");
    const last = parts.pop()!;
    const inner = parts.reduce((at, name) => (at[name] ??= {}) as Record<string, unknown>, rig);
    inner[last] = value;
  }
  return { rig, ...(chosen.route !== undefined && { route: chosen.route }) };
}

/** Return the first value of a choice: that of the frame where it is allowed. */
export function firstOf(limits: Limits, frame: unknown): unknown {
  if ("between" in limits) {
    const [low, high] = limits.between;
    return typeof frame === "number" ? Math.min(high, Math.max(low, frame)) : low;
  }
  if (Array.isArray(frame)) return frame.filter((entry) => limits.one_of.includes(entry));
  return limits.one_of.includes(frame as string) ? frame : limits.one_of[0];
}

export const isOver = (assignment: Assignment, now = Date.now()) => assignment.deadline !== null && Date.parse(assignment.deadline) <= now;
