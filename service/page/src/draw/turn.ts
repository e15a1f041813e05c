/** Turning of a drawing in space: by dragging, or by the arrow keys. */

import { useRef, useState } from "preact/hooks";
import type { View } from "./projection";

const FIRST: View = { turn: 0.5, tilt: 0.5 };
const STEP = Math.PI / 24; // of an arrow key
const DRAGGED = 0.008; // rad a pixel
const [LOWEST, HIGHEST] = [0.05, Math.PI / 2]; // a plate seen from its edge is a line

/** Return where a view has come to that is turned and tilted by some angles, rad. */
export function turned({ turn, tilt }: View, by: Partial<View>): View {
  return { turn: turn + (by.turn ?? 0), tilt: Math.min(HIGHEST, Math.max(LOWEST, tilt + (by.tilt ?? 0))) };
}

const KEYS: Record<string, Partial<View>> = {
  ArrowLeft: { turn: -STEP },
  ArrowRight: { turn: STEP },
  ArrowUp: { tilt: STEP },
  ArrowDown: { tilt: -STEP },
};

/** Return a view, and what lets keys and a pointer turn it. */
export function useTurn() {
  const [view, setView] = useState(FIRST);
  const last = useRef<[number, number] | null>(null);
  const onKeyDown = (event: KeyboardEvent) => {
    const by = KEYS[event.key];
    if (by) setView((old) => turned(old, by));
    else if (event.key === "0") setView(FIRST);
    else return;
    event.preventDefault();
  };
  const onPointerDown = (event: PointerEvent) => {
    (event.currentTarget as Element).setPointerCapture(event.pointerId);
    last.current = [event.clientX, event.clientY];
  };
  const onPointerMove = (event: PointerEvent) => {
    if (!last.current) return;
    const [x, y] = last.current;
    last.current = [event.clientX, event.clientY];
    setView((old) => turned(old, { turn: DRAGGED * (event.clientX - x), tilt: DRAGGED * (event.clientY - y) }));
  };
  const onPointerUp = () => {
    last.current = null;
  };
  return { view, handlers: { onKeyDown, onPointerDown, onPointerMove, onPointerUp, onPointerCancel: onPointerUp } };
}
