/** Requests to the public API. */

import { type Problem, posting, request } from "./http";
import { type Arrays, readNpz } from "./npz";
import { signedIn } from "./session";

export { type Problem, ProblemError, asProblem } from "./http";

export interface Job {
  id: string;
  state: "queued" | "running" | "succeeded" | "failed" | "cancelled";
  fraction: number;
  message: string;
  result_id: string | null;
  error: Problem | null;
  place: number | null;
}

const send = (path: string, init?: RequestInit) => signedIn(() => request(path, init));

export async function get<T>(path: string): Promise<T> {
  return (await send(path)).json();
}

export async function post<T>(path: string, body: unknown): Promise<T> {
  return (await send(path, posting(body))).json();
}

export async function patch<T>(path: string, body: unknown): Promise<T> {
  return (await send(path, { ...posting(body), method: "PATCH" })).json();
}

export async function put<T>(path: string, body: unknown): Promise<T> {
  return (await send(path, { ...posting(body), method: "PUT" })).json();
}

export async function upload<T>(path: string, form: FormData): Promise<T> {
  return (await send(path, { method: "POST", body: form })).json();
}

/** Return a reply as a file of a media type; a body makes it a POST. */
export async function file(path: string, accept: string, body?: unknown): Promise<Blob> {
  const init = body === undefined ? {} : posting(body);
  return (await send(path, { ...init, headers: { ...init.headers, Accept: accept } })).blob();
}

export async function arrays(path: string): Promise<Arrays> {
  const reply = await send(path, { headers: { Accept: "application/octet-stream" } });
  return readNpz(await reply.arrayBuffer());
}

export async function remove(path: string): Promise<void> {
  await send(path, { method: "DELETE" });
}

export const cancel = (job: string): Promise<void> => remove(`/jobs/${job}`);

/** Return the last state of a job; `tell` hears of every change before. */
export function follow(id: string, tell: (job: Job) => void, signal: AbortSignal): Promise<Job> {
  return new Promise((resolve, reject) => {
    if (signal.aborted) return;
    const events = new EventSource(`v1/jobs/${id}/events`);
    const stop = () => events.close();
    signal.addEventListener("abort", stop);
    events.onmessage = (event) => {
      const job = JSON.parse(event.data) as Job;
      tell(job);
      if (hasEnded(job)) {
        stop();
        resolve(job);
      }
    };
    events.onerror = () => {
      // The browser connects again by itself, unless the service refused.
      if (events.readyState !== EventSource.CLOSED || signal.aborted) return;
      // That may have been for want of a session: the job goes on meanwhile, and so does its stream afterwards.
      get<Job>(`/jobs/${id}`)
        .then((job) => (hasEnded(job) ? job : pause().then(() => follow(id, tell, signal))))
        .then(resolve, reject);
    };
  });
}

const hasEnded = (job: Job) => job.state !== "queued" && job.state !== "running";
const pause = () => new Promise((resolve) => setTimeout(resolve, 1000));
