/** The facets of a plate in motion, the nearer over the farther, coloured by how far they are from rest. */

import { useMemo } from "preact/hooks";
import type { Geometry } from "../model";
import { type View, depthOf } from "./projection";
import type { At } from "./shape";

const LEVELS = 7; // classes of colour, from farthest down to farthest up

/** Return the class of the colour of a motion, of which 1 is the largest. */
export function levelOf(motion: number): string {
  const index = Math.round(((Math.min(1, Math.max(-1, motion)) + 1) / 2) * (LEVELS - 1));
  return `level-${index}`;
}

interface SurfaceProps {
  geometry: Geometry;
  view: View;
  at: At;
  moved: Map<string, number[]>;
  /** Largest motion in the drawing. */
  swing: number;
}

export function Surface({ geometry, view, at, moved, swing }: SurfaceProps) {
  const facets = useMemo(() => {
    const far = (nodes: number[]) => nodes.reduce((sum, node) => sum + depthOf(geometry.nodes[node], view), 0) / nodes.length;
    return geometry.members.map(({ nodes }) => ({ nodes, depth: far(nodes) })).sort((a, b) => b.depth - a.depth);
  }, [geometry, view]);
  return (
    <g class="surface">
      {facets.map(({ nodes }) => {
        const motion = nodes.reduce((sum, node) => sum + (moved.get(String(node))?.[2] ?? 0), 0) / nodes.length / swing;
        return <path class={levelOf(motion)} d={`M${nodes.map((node) => at(node, moved).map((v) => v.toFixed(1)).join(" ")).join("L")}${nodes.length > 2 ? "Z" : ""}`} />;
      })}
    </g>
  );
}
