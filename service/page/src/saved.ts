/** What a user has stored, what is in the trash, and the address under which each is shown. */

import { file, get, patch, post, remove, upload } from "./api";
import { words } from "./format";
import type { State } from "./state";

export const KINDS = { measurement: "Tests", modal_model: "Modal models", update: "Updates", diagnosis: "Diagnoses" } as const;
export type Kind = keyof typeof KINDS;

const SINGULAR: Record<string, string> = { measurement: "Test", modal_model: "Modal model", update: "Update", diagnosis: "Diagnosis" };

/** Return the name of an entry, or what it is. */
export const nameOf = (entry: Entry, kind: string) => entry.name || (SINGULAR[kind] ?? words(kind));

export interface Entry {
  id: string;
  created: string;
  name: string;
  comment: string;
  made_from: Record<string, string>;
}

export interface DiscardedEntry extends Entry {
  kind: string;
  until: string;
}

const PATHS: Record<Kind, string> = { measurement: "/measurements", modal_model: "/modal-models", update: "/updates", diagnosis: "/diagnoses" };

interface Page<T> {
  items: T[];
  next: string | null;
}

/** Return the first entries of a list; those of one owner on a service with keys. */
function pageOf<T>(path: string, owner: string | undefined, limit: number): Promise<Page<T>> {
  const query = new URLSearchParams({ limit: String(limit) });
  if (owner) query.set("owner", owner);
  return get(`${path}?${query}`);
}

export const entries = (kind: Kind, owner: string | undefined, limit: number) => pageOf<Entry>(PATHS[kind], owner, limit);

export const trash = (owner: string | undefined) => pageOf<DiscardedEntry>("/trash", owner, 100);

export const rename = (kind: Kind, id: string, name: string) => patch<Entry>(`${PATHS[kind]}/${id}`, { name });

export const discard = (kind: Kind, id: string) => remove(`${PATHS[kind]}/${id}`);

export const restore = (id: string) => post<Entry>(`/trash/${id}/restore`, undefined);

export const projectFile = () => file("/projects/export", "application/zip");

/** Store what a project file holds; return how many objects of each kind that were. */
export async function addProject(chosen: File): Promise<Record<string, number>> {
  const form = new FormData();
  form.append("file", chosen);
  return (await upload<{ counts: Record<string, number> }>("/projects/import", form)).counts;
}

const NOTHING_SHOWN: Partial<State> = { t: [], f: [], x: undefined, u: undefined, d: undefined, j: undefined };

/** Return the change of the address that shows an entry; a structure that the entry does not name stays. */
export function shown(kind: Kind, entry: Entry): Partial<State> {
  const { structure_id, measurement_id, modal_model_id } = entry.made_from;
  const model: Partial<State> = structure_id ? { s: structure_id } : {};
  const t = measurement_id ? [measurement_id] : [];
  if (kind === "measurement") return { ...NOTHING_SHOWN, view: "measure", t: [entry.id] };
  if (kind === "modal_model") return { ...NOTHING_SHOWN, view: "extract", t, x: entry.id };
  if (kind === "update") return { ...NOTHING_SHOWN, ...model, view: "correlate", t, x: modal_model_id, u: entry.id };
  return { ...NOTHING_SHOWN, ...model, view: "diagnose", t, d: entry.id };
}
