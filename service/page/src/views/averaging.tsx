/** Averages as they build up: FRF and coherence after the first ones, played or at the student's pace. */

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { arrays } from "../api";
import { type Estimate, estimatesOf, meaningOf } from "../averaging";
import type { Problem } from "../http";
import type { Measurement } from "../model";
import type { Test } from "../plot/frf-stack";
import { useLoaded } from "../use";

interface TestAbout extends Test {
  about: Measurement;
}

export interface Averaging {
  estimates: Estimate[] | null;
  index: number;
  playing: boolean;
  /** The estimates of a new test are under way: what is played is not shown as a whole before. */
  waiting: boolean;
  problem: Problem | null;
  play(): void;
  show(index: number): void;
  pause(): void;
}

const WHOLE = 4500; // ms, of all steps
const STEP = [160, 500]; // shortest and longest
const isMoving = () => !matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Return the averaging of a test; that of a `fresh` one plays by itself, once, unless little motion is asked for. */
export function useAveraging(test: TestAbout | undefined, fresh: string | null): Averaging {
  const id = test && test.about.n_estimates > 1 ? test.id : null;
  const loaded = useLoaded(id && `estimates/${id}`, async () => estimatesOf(await arrays(`/measurements/${id}/estimates?precision=single`), test!.frfs));
  const [shown, setShown] = useState<{ id: string | null; index: number; playing: boolean } | null>(null);
  const played = useRef<string | null>(null);
  const estimates = loaded.value;
  const last = (estimates?.length ?? 1) - 1;
  const plays = id !== null && fresh === id && played.current !== id && isMoving();
  const current = shown && shown.id === id ? shown : { index: plays ? 0 : Infinity, playing: plays && estimates !== null };
  const index = Math.min(current.index, last);
  useEffect(() => {
    if (!current.playing) return;
    if (current !== shown) {
      played.current = id; // it has begun: from here on as if somebody had pressed the button
      setShown({ id, index, playing: true });
      return;
    }
    const wait = Math.min(Math.max(WHOLE / (last + 1), STEP[0]), STEP[1]);
    const timer = setTimeout(() => setShown({ id, index: index + 1, playing: index + 1 < last }), wait);
    return () => clearTimeout(timer);
  }, [current.playing, index, id, current === shown]);
  return {
    estimates,
    index,
    playing: current.playing,
    waiting: plays && loaded.loading,
    problem: loaded.problem,
    play: () => setShown({ id, index: index < last ? index : 0, playing: true }),
    show: (next) => setShown({ id, index: next, playing: false }),
    pause: () => setShown({ id, index, playing: false }),
  };
}

/** Return tests with the current one as it stood at the step that is shown. */
export function useStep<T extends Test>(tests: T[] | null, { estimates, index }: Averaging): T[] | null {
  return useMemo(() => {
    if (!tests || !estimates || index === estimates.length - 1) return tests;
    return [{ ...tests[0], frfs: estimates[index].frfs }, ...tests.slice(1)];
  }, [tests, estimates, index]);
}

export function AveragingBar({ averaging, about }: { averaging: Averaging; about: Measurement }) {
  const { estimates, index, playing } = averaging;
  if (!estimates) return null;
  const [{ count }, all] = [estimates[index], estimates[estimates.length - 1].count];
  // Whoever takes hold of the slider stays where it is, even if that is where it was.
  const hold = (event: Event) => playing && (event as KeyboardEvent).key !== "Tab" && averaging.pause();
  const forces = about.rig.exciter.kind === "hammer" ? 1 : about.inputs.length;
  return (
    <div class="averages averaging" role="group" aria-label="Averaging">
      <button type="button" onClick={playing ? averaging.pause : averaging.play}>{playing ? "Pause" : "Play"}</button>
      <input type="range" aria-label="Averages" aria-valuetext={`${count} of ${all} averages`} min={0} max={estimates.length - 1} value={index} onPointerDown={hold} onKeyDown={hold} onInput={(event) => averaging.show(Number(event.currentTarget.value))} />
      <p class="averages-words">
        <span><b>{count}</b> of {all} averages</span>
        <span class="hint">{meaningOf(count, forces)}</span>
      </p>
    </div>
  );
}
