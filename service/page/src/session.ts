/**
 * Who is signed in, on a service with keys. A key goes to the service and nowhere else: what stays in the
 * browser is a cookie that no script reads, and a note that there is one.
 */

import { useEffect, useState } from "preact/hooks";
import { type Problem, asProblem, posting, request } from "./http";

export interface Holder {
  id: string;
  name: string;
  role: string;
}

export interface Session {
  /** who is signed in; null: nobody, or the service has no keys */
  holder: Holder | null;
  /** the service has refused somebody who is not signed in */
  refused: boolean;
  /** the form is open */
  asking: boolean;
  /** why a link signed nobody in */
  told: Problem | null;
}

// A service without keys refuses `GET /v1/sessions`, and browsers write that to their console: it is asked
// only where somebody has signed in before.
const NOTE = "signed-in";

let session: Session = { holder: null, refused: false, asking: false, told: null };
const waiting: ((yes: boolean) => void)[] = []; // requests that go on when the form closes
let turn = 0; // how often somebody has signed in

export const holder = () => session.holder;

export function useSession(): Session {
  const [seen, setSeen] = useState(session);
  useEffect(() => {
    const read = () => setSeen(session);
    read(); // it may have changed before anybody listened
    addEventListener("sessionchange", read);
    return () => removeEventListener("sessionchange", read);
  }, []);
  return seen;
}

function change(next: Partial<Session>): void {
  session = { ...session, ...next };
  dispatchEvent(new Event("sessionchange"));
}

// What stands behind `#` reaches no server; the secret of a link leaves the address before anything else happens.
const ONCE = "#once=";

let entering: Promise<void> | null = null; // by a link

/** Sign in by the link in the address, if there is one. */
export function enter(): void {
  if (!location.hash.startsWith(ONCE)) return;
  const link = location.hash.slice(ONCE.length);
  history.replaceState(null, "", location.pathname);
  entering = opened({ link }).then((told) => {
    if (told) change({ told, refused: true, asking: true });
  });
}

/** Send a request; one that is refused for want of a session is sent again after signing in. */
export async function signedIn(send: () => Promise<Response>): Promise<Response> {
  await entering;
  const before = turn;
  try {
    return await send();
  } catch (error) {
    if (asProblem(error).status !== 401) throw error;
    // Somebody may have signed in while this request was on its way.
    if (before === turn && !(await ask())) throw error;
    return send();
  }
}

/** Open the form; return whether somebody has signed in when it closes. */
export function ask(): Promise<boolean> {
  change({ refused: true, asking: true });
  return new Promise((resolve) => waiting.push(resolve));
}

function close(yes: boolean): void {
  change({ asking: false, told: null });
  for (const resolve of waiting.splice(0)) resolve(yes);
}

export const decline = () => close(false);

/** Exchange a key for a session; return the problem of a key that does not count. */
export const signIn = (key: string) => opened({ key });

async function opened(proof: { key: string } | { link: string }): Promise<Problem | null> {
  try {
    const who = await holderOf(request("/sessions", posting(proof)));
    localStorage.setItem(NOTE, "yes");
    if (session.holder && session.holder.id !== who.id) return startAfresh(); // the page shows another person's work
    turn += 1;
    change({ holder: who, refused: false });
    close(true);
    return null;
  } catch (error) {
    return asProblem(error);
  }
}

/** Forget everything that the page has loaded. */
function startAfresh(): null {
  history.replaceState(null, "", location.pathname);
  location.reload();
  return null;
}

/** Find out who is signed in from an earlier visit. */
export async function resume(): Promise<void> {
  await entering;
  if (session.holder || !localStorage.getItem(NOTE)) return;
  try {
    change({ holder: await holderOf(request("/sessions")), refused: false });
  } catch (error) {
    const { status } = asProblem(error);
    if (status === 401) change({ refused: true });
    if (status === 401 || status === 403) localStorage.removeItem(NOTE);
  }
}

/** End the session, and forget what the page has loaded; return the problem if that failed. */
export async function signOut(): Promise<Problem | null> {
  try {
    await request("/sessions", { method: "DELETE" });
  } catch (error) {
    const problem = asProblem(error);
    if (problem.status !== 401) return problem; // 401: the session has ended by itself
  }
  localStorage.removeItem(NOTE);
  return startAfresh();
}

async function holderOf(reply: Promise<Response>): Promise<Holder> {
  const { id, name, role } = (await (await reply).json()) as Holder;
  return { id, name, role };
}
