/** State of the page: everything that a shared address brings back. Ids only; hidden effects never. */

import { useEffect, useState } from "preact/hooks";

export const VIEWS = ["rig", "measure", "extract", "correlate", "diagnose", "class"] as const;
export type View = (typeof VIEWS)[number];

export interface State {
  view: View;
  /** structure: the model */
  s?: string;
  /** tests, the current one first */
  t: string[];
  /** modal model */
  x?: string;
  /** modal models of the same test by other methods */
  f: string[];
  /** update */
  u?: string;
  /** diagnosis */
  d?: string;
  /** class */
  c?: string;
  /** assignment */
  a?: string;
  /** job under way */
  j?: string;
  /** rig that is being set up, where it differs from the usual one */
  rig?: string;
}

const SINGLE = ["s", "x", "u", "d", "c", "a", "j", "rig"] as const;
const LISTS = ["t", "f"] as const;

export function parse(hash: string): State {
  const [name, query = ""] = hash.replace(/^#\/?/, "").split("?");
  const params = new URLSearchParams(query);
  const view = VIEWS.find((known) => known === name) ?? "rig";
  const list = (key: string) => params.get(key)?.split(",").filter(Boolean) ?? [];
  const state: State = { view, t: list("t"), f: list("f") };
  for (const key of SINGLE) {
    const value = params.get(key);
    if (value) state[key] = value;
  }
  return state;
}

export function address(state: State): string {
  const params = new URLSearchParams();
  for (const key of SINGLE) {
    const value = state[key];
    if (value) params.set(key, value);
  }
  for (const key of LISTS) if (state[key].length) params.set(key, state[key].join(","));
  // Commas and colons are legal in a fragment, and ids are read by people.
  const query = params.toString().replaceAll("%2C", ",").replaceAll("%3A", ":");
  return `#${state.view}${query ? `?${query}` : ""}`;
}

/** Change the address; `replace` leaves no step for the browser's way back. */
export function go(change: Partial<State>, replace = false): void {
  const next = address({ ...parse(location.hash), ...change });
  if (next === location.hash) return;
  history[replace ? "replaceState" : "pushState"](null, "", next);
  dispatchEvent(new Event("addresschange"));
}

export function useAddress(): State {
  const [state, setState] = useState(() => parse(location.hash));
  useEffect(() => {
    const read = () => setState(parse(location.hash));
    const names = ["hashchange", "popstate", "addresschange"];
    for (const name of names) addEventListener(name, read);
    return () => names.forEach((name) => removeEventListener(name, read));
  }, []);
  return state;
}
