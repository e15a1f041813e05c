/** Requests to the public API. */

import { type Arrays, readNpz } from "./npz";

/** Problem document (RFC 9457) of a refused request. */
export interface Problem {
  title: string;
  status: number;
  detail: string;
  code: string;
  context: { field?: string; value?: unknown; allowed?: unknown };
}

export class ProblemError extends Error {
  constructor(readonly problem: Problem) {
    super(problem.detail);
  }
}

export interface Job {
  id: string;
  state: "queued" | "running" | "succeeded" | "failed" | "cancelled";
  fraction: number;
  message: string;
  result_id: string | null;
  error: Problem | null;
  place: number | null;
}

const UNREACHABLE: Problem = {
  title: "The service does not answer",
  status: 0,
  detail: "The laboratory cannot be reached.",
  code: "unreachable",
  context: {},
};

async function send(path: string, init: RequestInit = {}): Promise<Response> {
  let reply: Response;
  try {
    reply = await fetch(`v1${path}`, init);
  } catch {
    throw new ProblemError(UNREACHABLE);
  }
  if (!reply.ok) throw new ProblemError(await problemOf(reply));
  return reply;
}

async function problemOf(reply: Response): Promise<Problem> {
  try {
    return (await reply.json()) as Problem;
  } catch {
    return { ...UNREACHABLE, title: "The request failed", status: reply.status, detail: `The reply was ${reply.status}.` };
  }
}

export async function get<T>(path: string): Promise<T> {
  return (await send(path)).json();
}

export async function post<T>(path: string, body: unknown): Promise<T> {
  const init = { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  return (await send(path, init)).json();
}

export async function upload<T>(path: string, form: FormData): Promise<T> {
  return (await send(path, { method: "POST", body: form })).json();
}

export async function arrays(path: string): Promise<Arrays> {
  const reply = await send(path, { headers: { Accept: "application/octet-stream" } });
  return readNpz(await reply.arrayBuffer());
}

export async function cancel(job: string): Promise<void> {
  await send(`/jobs/${job}`, { method: "DELETE" });
}

/** Return the last state of a job; `tell` hears of every change before. */
export function follow(id: string, tell: (job: Job) => void, signal: AbortSignal): Promise<Job> {
  return new Promise((resolve, reject) => {
    const events = new EventSource(`v1/jobs/${id}/events`);
    const stop = () => events.close();
    signal.addEventListener("abort", stop);
    events.onmessage = (event) => {
      const job = JSON.parse(event.data) as Job;
      tell(job);
      if (job.state !== "queued" && job.state !== "running") {
        stop();
        resolve(job);
      }
    };
    events.onerror = () => {
      // The browser connects again by itself, unless the service refused.
      if (events.readyState !== EventSource.CLOSED || signal.aborted) return;
      get<Job>(`/jobs/${id}`).then(resolve, reject);
    };
  });
}
