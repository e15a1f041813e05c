/** What stands in the place of a result: nothing yet, under way, refused. */

import type { ComponentChildren } from "preact";
import type { Problem } from "../api";
import { short, words } from "../format";
import type { Work } from "../use";

export function Empty({ title, children }: { title: string; children?: ComponentChildren }) {
  return (
    <section class="empty">
      <h2>{title}</h2>
      {children}
    </section>
  );
}

export function Loading({ what }: { what: string }) {
  return <p class="loading" role="status">Loading {what} …</p>;
}

/** An error: the service's sentence, what is allowed, and what to do. */
export function ProblemNote({ problem, again }: { problem: Problem; again?: () => void }) {
  const { field, value, allowed } = problem.context ?? {};
  return (
    <section class="problem" role="alert">
      <h3>{problem.title}</h3>
      <p>{sentence(problem.detail)}</p>
      {field && !problem.detail.includes("field:") && (
        <p>
          <span class="term">{words(field)}</span>
          {value !== undefined && value !== null && <> is <code>{brief(value)}</code></>}
          {allowed !== undefined && allowed !== null && <>; allowed: <code>{brief(allowed)}</code></>}
        </p>
      )}
      <p class="advice">{ADVICE[problem.code] ?? "Change the value and try again."}</p>
      {again && <button type="button" onClick={again}>Try again</button>}
    </section>
  );
}

const ADVICE: Record<string, string> = {
  unreachable: "Is the service running? Start it with modallab serve, then try again.",
  not_found: "The address names something that this service does not have. Begin with step 1, Rig.",
  unauthorized: "Sign in at the top of the page, then try again.",
  queue_full: "Other work is waiting. Try again in a minute.",
  no_json: "Give the body of POST /v1/structures as JSON; the API reference describes it.",
  internal: "This is a fault of the service. Its log says more.",
  page: "This is a fault of the page. Load it again; your settings are in the address.",
};

export function sentence(text: string): string {
  const start = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?]$/.test(start) ? start : `${start}.`;
}

/** Return a value of a problem document as a few words. */
export function brief(value: unknown): string {
  if (typeof value === "number") return short(value, 6);
  if (typeof value === "string") return value;
  if (Array.isArray(value)) return value.slice(0, 8).map(brief).join(", ") + (value.length > 8 ? " …" : "");
  if (value && typeof value === "object") {
    return Object.entries(value).map(([name, entry]) => `${name} ${brief(entry)}`).join(", ");
  }
  return String(value);
}

/** Progress of a job, its end if that was not a result, and the button that stops it. */
export function WorkNote({ work, what }: { work: Work; what: string }) {
  const { job, problem, busy, stop } = work;
  if (problem) return <ProblemNote problem={problem} />;
  if (job?.state === "cancelled") return <p class="loading" role="status">The {what} was stopped.</p>;
  if (!busy) return null;
  const fraction = job?.fraction ?? 0;
  const state = job?.state === "queued" ? (job.place ? `waiting, place ${job.place}` : "waiting") : (job?.message || "starting").replaceAll("_", " ");
  return (
    <div class="work" role="status">
      <progress max={1} value={fraction} aria-label={`Progress of the ${what}`} />
      <span class="work-words">
        {Math.round(100 * fraction)} % · {state}
      </span>
      {job && <button type="button" class="quiet" onClick={stop}>Stop</button>}
    </div>
  );
}
