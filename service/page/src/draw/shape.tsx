/** A mode shape in motion: measured at its DoFs, the model's as a line behind it. */

import { useEffect, useMemo, useState } from "preact/hooks";
import type { Geometry } from "../model";
import type { Shape } from "../shape";
import { displacementOf, projectionOf, splitDof } from "./projection";
import { Members } from "./structure";

interface ShapeProps {
  geometry: Geometry;
  measured: Shape | null;
  model: Shape | null;
  label: string;
  svgRef?: { current: SVGSVGElement | null };
}

const SWING = 62; // largest displacement in the drawing
const PERIOD = 1900; // ms

export function ShapeDrawing({ geometry, measured, model, label, svgRef }: ShapeProps) {
  const projection = useMemo(() => projectionOf(geometry), [geometry]);
  const [moving, setMoving] = useState(() => !matchMedia("(prefers-reduced-motion: reduce)").matches);
  const phase = usePhase(moving);
  const [c, s] = [Math.cos(phase), Math.sin(phase)];
  const displaced = (shape: Shape) => {
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
  };
  const at = (node: string | number, moved?: Map<string, number[]>) => projection.point(geometry.nodes[node], moved?.get(String(node)));
  return (
    <figure class="shape-figure">
      <svg ref={svgRef} class="shape" viewBox={`0 0 ${projection.width} ${projection.height}`} role="img" aria-label={label}>
        <Members geometry={geometry} projection={projection} className="rest" />
        {model && <path class="model-line" d={memberPath(geometry, at, displaced(model))} />}
        {measured && <Measured geometry={geometry} measured={measured} moved={displaced(measured)} at={at} />}
      </svg>
      <button type="button" class="quiet" aria-pressed={moving} onClick={() => setMoving(!moving)}>{moving ? "Hold" : "Move"}</button>
    </figure>
  );
}

type At = (node: string | number, moved?: Map<string, number[]>) => [number, number];

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
