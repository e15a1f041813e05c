/** Hooks: what a view loads, and the job that it waits for. */

import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import { type Job, type Problem, asProblem, cancel, follow, post } from "./api";

export interface Loaded<T> {
  value: T | null;
  problem: Problem | null;
  loading: boolean;
}

const cache = new Map<string, Promise<unknown>>();

/** Return what `load` brings, loaded again when `key` changes; results are kept, for nothing stored changes. */
export function useLoaded<T>(key: string | null, load: () => Promise<T>): Loaded<T> {
  const [state, setState] = useState<Loaded<T> & { key: string | null }>({ ...IDLE, key: null });
  useEffect(() => {
    if (key === null) return;
    let current = true;
    if (!cache.has(key)) cache.set(key, load());
    const promise = cache.get(key) as Promise<T>;
    promise.then(
      (value) => current && setState({ key, value, problem: null, loading: false }),
      (error) => {
        cache.delete(key);
        if (current) setState({ key, value: null, problem: asProblem(error), loading: false });
      },
    );
    return () => {
      current = false;
    };
  }, [key]);
  if (key === null) return IDLE;
  return state.key === key ? state : { value: null, problem: null, loading: true };
}

const IDLE = { value: null, problem: null, loading: false };

/** Return what was loaded, and while the next is not there yet, the last. */
export function useKept<T>(loaded: Loaded<T>): Loaded<T> {
  const last = useRef<T | null>(null);
  if (loaded.value !== null) last.current = loaded.value;
  return { ...loaded, value: loaded.loading ? last.current : loaded.value };
}

/** Return what `load` brings now, after `again()`, and every so many milliseconds: for what others change. */
export function usePolled<T>(key: string, load: () => Promise<T>, every = 0): Loaded<T> & { again(): void } {
  const [state, setState] = useState<Loaded<T>>({ value: null, problem: null, loading: true });
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    let current = true;
    const read = () =>
      load().then(
        (value) => current && setState({ value, problem: null, loading: false }),
        (error) => current && setState((old) => ({ ...old, problem: asProblem(error), loading: false })),
      );
    read();
    const timer = every ? setInterval(() => document.hidden || read(), every) : 0;
    return () => {
      current = false;
      clearInterval(timer);
    };
  }, [key, turn]);
  return { ...state, again: useCallback(() => setTurn((n) => n + 1), []) };
}

export interface Work {
  job: Job | null;
  problem: Problem | null;
  busy: boolean;
  /** Send a request that starts a job, and follow it; of several requests one after the other. */
  start(path: string, ...bodies: (unknown | (() => Promise<unknown>))[]): void;
  stop(): void;
}

/** Return the work of a view: jobs that are started, followed, and end in ids given to `done`. */
export function useWork(done: (...resultIds: string[]) => void): Work {
  const [job, setJob] = useState<Job | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const abort = useRef<AbortController | null>(null);
  useEffect(() => () => abort.current?.abort(), []);
  const start = useCallback((path: string, ...bodies: (unknown | (() => Promise<unknown>))[]) => {
    const controller = new AbortController();
    abort.current?.abort();
    abort.current = controller;
    setProblem(null);
    setJob(null);
    setBusy(true);
    const run = async () => {
      const results: string[] = [];
      for (const body of bodies) {
        const request = typeof body === "function" ? await body() : body;
        const first = await post<Job>(path, request);
        setJob(first);
        const last = await follow(first.id, setJob, controller.signal);
        if (last.state === "failed") setProblem(last.error);
        if (last.state !== "succeeded") return;
        results.push(last.result_id!);
      }
      done(...results);
    };
    run()
      .catch((error) => setProblem(asProblem(error)))
      .finally(() => setBusy(false));
  }, [done]);
  const stop = () => {
    if (job) cancel(job.id).catch((error) => setProblem(asProblem(error)));
  };
  return { job, problem, busy, start, stop };
}

export { asProblem };

/** Return what runs a short action: whether one is under way, and why the last one was refused. */
export function useActions(tell: (text: string) => void = () => undefined, after: () => void = () => undefined) {
  const [busy, setBusy] = useState(false);
  const [problem, setProblem] = useState<Problem | null>(null);
  const run = async (action: () => Promise<unknown>, text = "") => {
    setBusy(true);
    setProblem(null);
    try {
      const outcome = await action();
      tell(typeof outcome === "string" ? outcome : text);
      after();
    } catch (error) {
      tell("");
      setProblem(asProblem(error));
    }
    setBusy(false);
  };
  return { run, busy, problem };
}
