/** From coordinates of a structure to the plane of a drawing. */

import type { Geometry } from "../model";

export type Point = [number, number];

export interface Projection {
  /** Coordinates and displacement, m, to the drawing. */
  point(place: number[], displacement?: number[]): Point;
  /** Unit length of a motion in the drawing, by direction. */
  width: number;
  height: number;
  flat: boolean;
}

const WIDTH = 1000;
const MARGIN = 70;
const BELOW = 95; // room for a shaker, and for accelerometers above
const TALLEST = 420; // of the structure itself
const TURNED = 560; // height of a drawing that can be turned: the page shall not move with it

/** From where a structure in space is seen, rad: turned about its vertical, tilted towards the reader. */
export interface View {
  turn: number;
  tilt: number;
}

/** True where a structure moves out of the plane of a drawing. */
export const inSpace = (geometry: Geometry): boolean => geometry.dofs.some((dof) => dof.endsWith(":+Z"));

/** Return how a structure is seen: beams and frames from the front, plates and bodies in space from above, or from a side of choice. */
export function projectionOf(geometry: Geometry, view?: View): Projection {
  const places = Object.values(geometry.nodes);
  const chosen = inSpace(geometry) ? view : undefined;
  const see = !inSpace(geometry) ? fromTheFront : chosen ? from(chosen) : fromAbove;
  const seen = places.map((place) => see(place[0], place[1], place[2] ?? 0));
  const [left, right] = extent(seen.map((p) => p[0]));
  const [bottom, top] = extent(seen.map((p) => p[1]));
  const wide = Math.max(right - left, 1e-9);
  const tall = chosen ? TURNED - 2 * BELOW : TALLEST;
  const scale = Math.min((WIDTH - 2 * MARGIN) / wide, tall / Math.max(top - bottom, 1e-9));
  const height = chosen ? TURNED : Math.max((top - bottom) * scale + 2 * BELOW, 230);
  const offset = (WIDTH - wide * scale) / 2;
  return {
    width: WIDTH,
    height,
    flat: top - bottom < 1e-9 * wide,
    point(place, displacement = [0, 0, 0]) {
      const [x, y] = see(place[0], place[1], place[2] ?? 0);
      const [u, v] = see(displacement[0], displacement[1], displacement[2]);
      const middle = height / 2 + ((bottom + top) / 2) * scale;
      return [offset + (x - left) * scale + u, middle - y * scale - v];
    },
  };
}

function fromTheFront(x: number, y: number): Point {
  return [x, y];
}

function fromAbove(x: number, y: number, z: number): Point {
  return [0.94 * x + 0.52 * y, -0.2 * x + 0.42 * y + 0.9 * z];
}

function from({ turn, tilt }: View): (x: number, y: number, z: number) => Point {
  return (x, y, z) => [x * Math.cos(turn) - y * Math.sin(turn), (x * Math.sin(turn) + y * Math.cos(turn)) * Math.sin(tilt) + z * Math.cos(tilt)];
}

/** Return how far behind the drawing a place lies, m. */
export function depthOf([x, y, z = 0]: number[], { turn, tilt }: View): number {
  return (x * Math.sin(turn) + y * Math.cos(turn)) * Math.cos(tilt) - z * Math.sin(tilt);
}

function extent(values: number[]): Point {
  return [Math.min(...values), Math.max(...values)];
}

export function splitDof(dof: string): { node: string; sign: number; direction: string } {
  const [node, motion] = dof.split(":");
  return { node, sign: motion.startsWith("-") ? -1 : 1, direction: motion.replace(/^[+-]/, "") };
}

export function displacementOf(direction: string, amount: number): number[] {
  return ["X", "Y", "Z"].map((axis) => (axis === direction ? amount : 0));
}
