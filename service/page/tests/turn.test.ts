import { expect, test } from "vitest";
import { depthOf, projectionOf } from "../src/draw/projection";
import { levelOf } from "../src/draw/surface";
import { turned } from "../src/draw/turn";

const PLATE = {
  nodes: { 1: [0, 0, 0], 2: [2, 0, 0], 3: [2, 1, 0], 4: [0, 1, 0] },
  members: [{ number: 1, nodes: [1, 2, 3, 4] }],
  dofs: ["1:+Z", "2:+Z", "3:+Z", "4:+Z"],
};

test("from straight above a plate has its own proportions, and its motion is not seen", () => {
  const { point } = projectionOf(PLATE, { turn: 0, tilt: Math.PI / 2 });
  const [[x1, y1], [x2, y2], , [x4, y4]] = Object.values(PLATE.nodes).map((place) => point(place));
  expect(y2).toBeCloseTo(y1, 9);
  expect(x4).toBeCloseTo(x1, 9);
  expect((x2 - x1) / (y1 - y4)).toBeCloseTo(2, 9);
  expect(point(PLATE.nodes[1], [0, 0, 50])[1]).toBeCloseTo(y1, 9);
});

test("a motion upwards is drawn upwards, the shorter the more a plate is tilted", () => {
  const rise = (tilt: number) => {
    const { point } = projectionOf(PLATE, { turn: 0.3, tilt });
    return point(PLATE.nodes[1])[1] - point(PLATE.nodes[1], [0, 0, 50])[1];
  };
  expect(rise(0.2)).toBeCloseTo(50 * Math.cos(0.2), 9);
  expect(rise(1.2)).toBeCloseTo(50 * Math.cos(1.2), 9);
});

test("a turn by half a circle brings to the front what was behind", () => {
  const view = { turn: 0.4, tilt: 0.5 };
  const order = (by: number) => depthOf([2, 1, 0], turned(view, { turn: by })) - depthOf([0, 0, 0], turned(view, { turn: by }));
  expect(order(Math.PI)).toBeCloseTo(-order(0), 9);
});

test("a plate is tilted neither under its edge nor over its middle", () => {
  expect(turned({ turn: 0, tilt: 0.5 }, { tilt: -9 }).tilt).toBeGreaterThan(0);
  expect(turned({ turn: 0, tilt: 0.5 }, { tilt: 9 }).tilt).toBeCloseTo(Math.PI / 2, 9);
});

test("rest is grey, the largest motions have the strongest colours", () => {
  expect([-1, 0, 1, 2].map(levelOf)).toEqual(["level-0", "level-3", "level-6", "level-6"]);
});
