/** A structure with the hardware of a test on it. */

import { useMemo, useRef, useState } from "preact/hooks";
import type { Geometry } from "../model";
import { type Point, type Projection, displacementOf, projectionOf, splitDof } from "./projection";

interface Props {
  geometry: Geometry;
  drive: string;
  responses: string[];
  direction: string;
  exciter: "shaker" | "hammer";
  stinger: boolean;
  /** A node was clicked, or Enter pressed on it. */
  toggle(node: string): void;
  move(node: string): void;
  svgRef?: { current: SVGSVGElement | null };
}

export function RigDrawing(props: Props) {
  const { geometry, drive, responses, direction, toggle, move } = props;
  const projection = useMemo(() => projectionOf(geometry), [geometry]);
  const free = useMemo(() => new Set(geometry.dofs), [geometry]);
  const nodes = useMemo(
    () => Object.keys(geometry.nodes).filter((node) => ["X", "Y", "Z"].some((d) => free.has(`${node}:+${d}`))),
    [geometry],
  );
  const [current, setCurrent] = useState(nodes[0]);
  const own = useRef<SVGSVGElement>(null);
  const svg = props.svgRef ?? own;
  const focus = (node: string | undefined) => {
    if (node === undefined) return;
    setCurrent(node);
    svg.current?.querySelector<SVGElement>(`[data-node="${node}"]`)?.focus();
  };
  const onKeyDown = (event: KeyboardEvent, node: string) => {
    const way = WAYS[event.key];
    if (way) focus(neighbour(geometry, projection, nodes, node, way));
    else if (event.key === "Enter" || event.key === " ") toggle(node);
    else if (event.key.toLowerCase() === "d") move(node);
    else return;
    event.preventDefault();
  };
  const at = (node: string) => projection.point(geometry.nodes[node]);
  const heard = new Map(responses.map((dof) => [splitDof(dof).node, splitDof(dof)]));
  return (
    <svg ref={svg} class="rig-drawing" viewBox={`0 0 ${projection.width} ${projection.height}`} role="group" aria-label="The structure with its rig. Arrow keys move from node to node, Enter sets or removes an accelerometer, D moves the drive.">
      <Members geometry={geometry} projection={projection} />
      <Supports geometry={geometry} projection={projection} />
      <Exciter at={at(splitDof(drive).node)} dof={drive} hammer={props.exciter === "hammer"} stinger={props.stinger} />
      {responses.map((dof) => <Accelerometer at={at(splitDof(dof).node)} dof={dof} />)}
      {nodes.map((node) => {
        const [x, y] = at(node);
        const sensor = heard.get(node);
        const driven = splitDof(drive).node === node;
        return (
          <g
            class={`node${driven ? " driven" : ""}`}
            role="button"
            tabindex={node === current ? 0 : -1} // an attribute of SVG keeps its case
            aria-pressed={sensor !== undefined}
            aria-label={`Node ${node}${sensor ? `, accelerometer ${sensor.direction}` : ""}${driven ? ", driven" : ""}`}
            data-node={node}
            onClick={() => { setCurrent(node); toggle(node); }}
            onFocus={() => setCurrent(node)}
            onKeyDown={(event) => onKeyDown(event, node)}
          >
            <circle class="target" cx={x} cy={y} r={nodes.length > 150 ? 9 : 16} />
            <circle class="dot" cx={x} cy={y} r={nodes.length > 60 ? 3.2 : 4.5} />
            {labelled(node, nodes.length) && <text x={driven ? x - 20 : x} y={y + (projection.flat ? 32 : 20)}>{node}</text>}
          </g>
        );
      })}
      <Arrow direction={direction} projection={projection} />
    </svg>
  );
}

const labelled = (node: string, count: number) => count <= 24 || (count <= 130 && Number(node) % 5 === 1);

const WAYS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** Return the nearest node that lies that way in the drawing. */
function neighbour(geometry: Geometry, projection: Projection, nodes: string[], from: string, way: Point) {
  const [x0, y0] = projection.point(geometry.nodes[from]);
  let best: string | undefined;
  let least = Infinity;
  for (const node of nodes) {
    const [x, y] = projection.point(geometry.nodes[node]);
    const along = (x - x0) * way[0] + (y - y0) * way[1];
    const beside = Math.abs((x - x0) * way[1]) + Math.abs((y - y0) * way[0]);
    if (along > 1 && along >= 0.5 * beside && along + 2 * beside < least) {
      least = along + 2 * beside;
      best = node;
    }
  }
  return best;
}

export function Members({ geometry, projection, className, hue }: { geometry: Geometry; projection: Projection; className?: string; hue?: (member: number) => string | undefined }) {
  return (
    <g class={className ?? "members"}>
      {geometry.members.map(({ number, nodes }) => {
        const points = nodes.map((node) => projection.point(geometry.nodes[node]).map((v) => v.toFixed(1)).join(","));
        const level = hue?.(number);
        return <path class={level} d={`M${points.join("L")}${nodes.length > 2 ? "Z" : ""}`}><title>{`member ${number}`}</title></path>;
      })}
    </g>
  );
}

function Supports({ geometry, projection }: { geometry: Geometry; projection: Projection }) {
  const held = Object.keys(geometry.nodes).filter((node) => !geometry.dofs.some((dof) => dof.startsWith(`${node}:`)));
  return (
    <g class="support" aria-hidden="true">
      {held.slice(0, 200).map((node) => {
        const [x, y] = projection.point(geometry.nodes[node]);
        const strokes = [-30, -18, -6, 6, 18].map((dy) => `M${x - 2} ${y + dy}l-12 12`).join("");
        return <path d={`M${x - 2} ${y - 30}v60${strokes}`} />;
      })}
    </g>
  );
}

function Exciter({ at: [x, y], dof, hammer, stinger }: { at: Point; dof: string; hammer: boolean; stinger: boolean }) {
  const { direction } = splitDof(dof);
  const turn = direction === "X" ? 90 : 0;
  return (
    <g class="exciter" transform={`translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${turn})`}>
      <title>{hammer ? `hammer at ${dof}` : `shaker at ${dof}, through ${stinger ? "a stinger and " : ""}a force transducer`}</title>
      {hammer ? (
        <path d="M0 8v14M-9 22h18v16h-18zM9 27h26v6h-26" />
      ) : (
        <>
          <path class="transducer" d="M-8 7h16v9h-16z" />
          <path class="stinger" d="M0 16v34" />
          <path class="body" d="M-21 50h42v30h-42zM-27 80h54M-9 58h18M-9 65h18" />
        </>
      )}
    </g>
  );
}

function Accelerometer({ at: [x, y], dof }: { at: Point; dof: string }) {
  const { direction, sign } = splitDof(dof);
  const turn = (direction === "X" ? 90 : 0) + (sign < 0 ? 180 : 0);
  return (
    <g class="accelerometer" transform={`translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${turn})`} aria-hidden="true">
      <path d="M-7 -7h14v-13h-14z" />
      <path class="cable" d="M0 -20c0 -12 6 -12 10 -20" />
    </g>
  );
}

function Arrow({ direction, projection }: { direction: string; projection: Projection }) {
  const origin = projection.point([0, 0, 0]);
  const tip = projection.point([0, 0, 0], displacementOf(direction, 30));
  const [dx, dy] = [tip[0] - origin[0], tip[1] - origin[1]];
  return (
    <g class="axis" transform="translate(24 58)" aria-hidden="true">
      <path d={`M0 0l${dx} ${dy}`} />
      <circle cx={dx} cy={dy} r="2.5" />
      <text x={dx + 12} y={dy + 5}>{`+${direction}`}</text>
    </g>
  );
}

