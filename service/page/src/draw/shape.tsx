/** A mode shape in motion: measured at its DoFs, the model's as a line behind it. */

import { useEffect, useMemo, useState } from "preact/hooks";
import type { Geometry } from "../model";
import type { Shape } from "../shape";
import { displacementOf, inSpace, projectionOf, splitDof } from "./projection";
import { Members } from "./structure";
import { Surface } from "./surface";
import { useTurn } from "./turn";

interface ShapeProps {
  geometry: Geometry;
  measured: Shape | null;
  model: Shape | null;
  label: string;
  svgRef?: { current: SVGSVGElement | null };
}

export type At = (node: string | number, moved?: Map<string, number[]>) => [number, number];

const SWING = 62; // largest displacement in the drawing
const PERIOD = 1900; // ms
const KEYS = "Arrow keys turn it, 0 turns it back.";

export function ShapeDrawing({ geometry, measured, model, label, svgRef }: ShapeProps) {
  const { view, handlers } = useTurn();
  const space = useMemo(() => inSpace(geometry), [geometry]);
  const projection = useMemo(() => projectionOf(geometry, view), [geometry, view]);
  const [moving, setMoving] = useState(() => !matchMedia("(prefers-reduced-motion: reduce)").matches);
  const phase = usePhase(moving);
  const at: At = (node, moved) => projection.point(geometry.nodes[node], moved?.get(String(node)));
  const modelMoved = model && displaced(model, phase);
  const role = space ? { role: "group" as const, tabindex: 0, "aria-label": `${label}. ${KEYS}`, ...handlers } : { role: "img" as const, "aria-label": label };
  return (
    <figure class="shape-figure">
      <svg ref={svgRef} class={space ? "shape in-space" : "shape"} viewBox={`0 0 ${projection.width} ${projection.height}`} {...role}>
        <Members geometry={geometry} projection={projection} className="rest" />
        {modelMoved && (space ? <Surface geometry={geometry} view={view} at={at} moved={modelMoved} swing={SWING} /> : <path class="model-line" d={memberPath(geometry, at, modelMoved)} />)}
        {measured && <Measured geometry={geometry} measured={measured} moved={displaced(measured, phase)} at={at} />}
      </svg>
      <button type="button" class="quiet" aria-pressed={moving} onClick={() => setMoving(!moving)}>{moving ? "Hold" : "Move"}</button>
    </figure>
  );
}

/** Return the displacement of each node, in units of the drawing, at a phase of the motion. */
function displaced(shape: Shape, phase: number): Map<string, number[]> {
  const [c, s] = [Math.cos(phase), Math.sin(phase)];
  const by = new Map<string, number[]>();
  shape.dofs.forEach((dof, i) => {
    const { node, sign, direction } = splitDof(dof);
    if (direction.startsWith("R")) return;
    const amount = sign * SWING * (shape.real[i] * c - shape.imaginary[i] * s);
    const [x, y, z] = displacementOf(direction, amount);
    const old = by.get(node) ?? [0, 0, 0];
    by.set(node, [old[0] + x, old[1] + y, old[2] + z]);
  });
  return by;
}

function memberPath(geometry: Geometry, at: At, moved: Map<string, number[]>): string {
  return geometry.members
    .map(({ nodes }) => `M${nodes.map((node) => at(node, moved).map((v) => v.toFixed(1)).join(" ")).join("L")}${nodes.length > 2 ? "Z" : ""}`)
    .join("");
}

function Measured({ geometry, measured, moved, at }: { geometry: Geometry; measured: Shape; moved: Map<string, number[]>; at: At }) {
  const nodes = [...new Set(measured.dofs.map((dof) => splitDof(dof).node))].filter((node) => geometry.nodes[node]);
  const straight = new Set(Object.values(geometry.nodes).map((place) => place[1])).size === 1;
  const through = straight && nodes.length > 1 ? `M${nodes.map((node) => at(node, moved).map((v) => v.toFixed(1)).join(" ")).join("L")}` : "";
  return (
    <g class="measured-shape">
      {through && <path class="through" d={through} />}
      {nodes.map((node) => {
        const [x0, y0] = at(node);
        const [x1, y1] = at(node, moved);
        return (
          <>
            <path d={`M${x0.toFixed(1)} ${y0.toFixed(1)}L${x1.toFixed(1)} ${y1.toFixed(1)}`} />
            <circle cx={x1.toFixed(1)} cy={y1.toFixed(1)} r="5" />
          </>
        );
      })}
    </g>
  );
}

function usePhase(moving: boolean): number {
  const [phase, setPhase] = useState(0);
  useEffect(() => {
    if (!moving) {
      setPhase(0);
      return;
    }
    let frame = 0;
    const begin = performance.now();
    const draw = (now: number) => {
      setPhase((2 * Math.PI * (now - begin)) / PERIOD);
      frame = requestAnimationFrame(draw);
    };
    frame = requestAnimationFrame(draw);
    return () => cancelAnimationFrame(frame);
  }, [moving]);
  return phase;
}
