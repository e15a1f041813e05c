/** What the service answers, as far as the page reads it. */

import { arrays, get } from "./api";
import type { Place } from "./format";
import { type Frfs, frfsOf } from "./frf";

export interface Parameter {
  unit: string;
  lower: number;
  upper: number;
  absent: number | null;
  doc: string;
}

export interface CatalogueEntry {
  kind: string;
  summary: string;
  parameters: Record<string, Parameter>;
}

export interface Structure {
  id: string;
  name: string;
  n_nodes: number;
  n_dofs: number;
  members: number;
}

export interface Geometry {
  nodes: Record<string, number[]>;
  members: { number: number; nodes: number[] }[];
  dofs: string[];
}

export interface StructureModes {
  frequencies: number[];
  loss_factors: number[];
  n_rigid_body: number;
}

export interface Measurement {
  id: string;
  created: string;
  averages: number | null;
  kind: string;
  outputs: string[];
  inputs: string[];
  n_lines: number;
  n_records: number;
  n_estimates: number;
  frequency_min: number;
  frequency_max: number;
  notes: string[];
  route: string | null;
  rig: { analyser: { window: string; estimator: string; excitation: { kind: string } }; exciter: { kind: string } };
}

export interface Spread {
  min: number;
  max: number;
  mean: number;
  sd: number;
  n: number;
}

export interface Mode {
  frequency: number;
  loss_factor: number;
  frequency_spread: Spread | null;
  loss_factor_spread: Spread | null;
  standard_errors: { frequency?: number; loss_factor?: number };
  flags: string[];
}

export interface ModalModel {
  id: string;
  modes: Mode[];
  method: string;
  measurement_id: string | null;
  notes: string[];
  choices: Record<string, string>;
  dofs: string[];
  references: string[];
}

/** Poles of a global method at rising model orders. */
export interface Chart {
  order: number[];
  frequency: number[];
  loss_factor: number[];
  /** Agreement with a pole of the order before: 0 new, 1 in frequency, 2 in damping too, 3 in shape too. */
  stability: number[];
  /** Number of the mode that each pole belongs to. */
  mode: (number | null)[];
  modes: number[];
  doubtful: { frequency: number; loss_factor: number | null; reason: string }[];
  indicators: { freq: number[]; cmif: number[][] };
}

export interface Effect {
  kind: string;
  at: Place;
  parameters: Record<string, { value: number; standard_error: number | null; unit: string }>;
}

export interface Rival {
  kind: string;
  at: Place;
  probability: number;
  gap_after: number;
}

/** Effect of no catalogue, solved for line by line. */
export interface Unknown {
  cause: "internal_force" | "channel_gain" | "common_gain";
  at: Place;
  unit: string;
  curve_model: string | null;
  source: string | null;
  parameters: Effect["parameters"];
  gap_before: number | null;
  gap_after: number | null;
  held_out_gap_before: number | null;
  held_out_gap_after: number | null;
  rivals_alike: Pick<Unknown, "cause" | "at">[];
}

export interface Step {
  effect: Effect;
  probability: number;
  gap_before: number;
  gap_after: number;
  held_out_gap_before: number | null;
  held_out_gap_after: number | null;
  rivals: Rival[];
  rivals_alike: { kind: string; at: Place }[];
}

export interface Diagnosis {
  id: string;
  verdict: string;
  headline: string;
  located: { words: string[]; bands: number[][] };
  steps: Step[];
  remaining_gap: number;
  gaps: { before: Record<string, number | null>; after: Record<string, number | null> };
  candidates: Rival[];
  unknown: Unknown | null;
  next_test: { why: string; change: Record<string, unknown>; separates: string[]; expected_separation: number | null } | null;
  follow_ups: { measurement_id: string; changed: Record<string, unknown> }[];
  notes: string[];
  structure_id: string;
  rig_id: string;
}

export const catalogue = (family: string) => get<CatalogueEntry[]>(`/catalog/${family}`);
export const structure = (id: string) => get<Structure>(`/structures/${id}`);
export const geometry = (id: string) => get<Geometry>(`/structures/${id}/geometry`);
export const structureModes = (id: string) => get<StructureModes>(`/structures/${id}/modes?count=10`);
export const measurement = (id: string) => get<Measurement>(`/measurements/${id}`);
export const modalModel = (id: string) => get<ModalModel>(`/modal-models/${id}`);
export const stabilisation = (id: string) => get<Chart>(`/modal-models/${id}/chart`);
export const diagnosis = (id: string) => get<Diagnosis>(`/diagnoses/${id}`);
export const frfs = async (id: string): Promise<Frfs> => frfsOf(await arrays(`/measurements/${id}/arrays`));
