/** Signing in on a service with keys: the form, and who is there. */

import { useEffect, useRef, useState } from "preact/hooks";
import type { Problem } from "../http";
import { type Session, ask, decline, signIn, signOut } from "../session";
import { sentence } from "./notes";

/** The form over the page: what has been typed below it stays. */
export function SignInForm({ told }: { told: Problem | null }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const field = useRef<HTMLInputElement>(null);
  const [wrong, setProblem] = useState<Problem | null>(null);
  const problem = wrong ?? told;
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    const shown = dialog.current!;
    shown.showModal();
    field.current!.focus();
    return () => shown.close(); // which gives the focus back
  }, []);
  const send = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    const refused = await signIn(field.current!.value.trim());
    setBusy(false);
    setProblem(refused);
    if (refused) field.current?.select();
  };
  return (
    <dialog ref={dialog} class="sign-in" aria-labelledby="sign-in-title" onCancel={decline}>
      <form onSubmit={send}>
        <h2 id="sign-in-title">Sign in</h2>
        <p class="hint" id="sign-in-hint">This laboratory asks for a key. Your instructor gives it to you, or a link that signs you in once.</p>
        <label for="key">Key</label>
        <span class="input">
          <input
            ref={field}
            id="key"
            type="password"
            autocomplete="off"
            spellcheck={false}
            required
            aria-invalid={problem !== null || undefined}
            aria-describedby={problem ? "sign-in-wrong sign-in-hint" : "sign-in-hint"}
          />
        </span>
        {problem && <p class="wrong" id="sign-in-wrong" role="alert">{sentence(problem.detail)}</p>}
        <div class="sign-in-buttons">
          <button type="submit" class="primary" disabled={busy}>Sign in</button>
          <button type="button" class="quiet" onClick={decline}>Not now</button>
        </div>
      </form>
    </dialog>
  );
}

/** Name and role of who is signed in; nothing on a service without keys. */
export function Account({ session }: { session: Session }) {
  const [problem, setProblem] = useState<Problem | null>(null);
  if (!session.holder) {
    return session.refused ? <button type="button" class="quiet" onClick={ask}>Sign in</button> : null;
  }
  const { name, role } = session.holder;
  return (
    <div class="account">
      <span class="account-name" title={name}>{name}</span>
      <span class="account-role">{role}</span>
      <button type="button" class="quiet" onClick={async () => setProblem(await signOut())}>Sign out</button>
      {problem && <span class="wrong" role="alert">{sentence(problem.detail)}</span>}
    </div>
  );
}
