/** Hidden effects: switched on here, in no log book, and in no address that could be shared. */

import rows from "./effects.json";
import type { HiddenEffect } from "./python";

export interface HiddenRow {
  group: string;
  kind: string;
  place: "dof" | "members" | "channel" | "drive" | "everywhere";
  parameters: Record<string, number>;
}

export const HIDDEN_ROWS = rows as HiddenRow[];

let chosen: HiddenEffect[] = [];

/** Return the effects that are switched on; they live as long as the page. */
export const hiddenEffects = () => chosen;

export function setHiddenEffects(effects: HiddenEffect[]): void {
  chosen = effects;
}

/** Return where an effect of a row sits at first: its kind of place, in the middle of what there is. */
export function usualPlace(row: HiddenRow, dofs: string[], members: number[], responses: string[], drive: string): unknown {
  const middle = <T>(list: T[]) => list[Math.floor(list.length * 0.4)];
  switch (row.place) {
    case "dof":
      return middle(dofs);
    case "members":
      return { members: [middle(members)] };
    case "channel":
      return { channels: [middle(responses)] };
    case "drive":
      return drive;
    default:
      return null;
  }
}
