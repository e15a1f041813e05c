/** A plot over frequency: zoom by dragging or by keys, cursor line by line. */

import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { firstAtLeast, thin } from "../thin";
import { onLightChange, resolve, rgb } from "./colour";
import { valueRange } from "./extent";
import { decades, logTicks, tickText } from "./log-ticks";
import { density, paint } from "./raster";

export type Range = [number, number];

export interface Line {
  label: string;
  y: Float64Array;
  tone: string;
  dash?: number[];
  width?: number;
  /** Its own lines, where they are not those of the plot; `y` are then its values nearest to the plot's. */
  own?: { x: Float64Array; y: Float64Array };
}

export interface ChartProps {
  title: string;
  x: Float64Array;
  lines: Line[];
  unit: string;
  log?: boolean;
  limits?: Range;
  /** Least value that a logarithmic scale has to show. */
  floor?: number;
  /** Curves that set the range of values in place of those drawn. */
  scale?: Float64Array[];
  range: Range | null;
  setRange(range: Range | null): void;
  height: number;
  /** Bands to shade. */
  bands?: Range[];
  /** A dragged band; without it, dragging zooms. */
  onBand?(band: Range): void;
  onCursor?(index: number | null): void;
  sync?: string;
  /** Lines between which the random error lies. */
  envelope?: { low: Float64Array; high: Float64Array };
}

export const MANY = 24; // curves beyond which their density is drawn

export function Chart(props: ChartProps) {
  const host = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const latest = useRef(props);
  latest.current = props;
  const [light, setLight] = useState(0);
  useEffect(() => onLightChange(() => setLight((n) => n + 1)), []);
  useEffect(() => {
    const element = host.current!;
    const made = create(element, latest);
    plot.current = made;
    const observer = new ResizeObserver(() => made.setSize({ width: element.clientWidth, height: props.height }));
    observer.observe(element);
    return () => {
      observer.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [props.x, props.lines, props.log, props.height, props.unit, light]);
  useEffect(() => {
    const [min, max] = props.range ?? fullRange(props.x);
    plot.current?.setScale("x", { min, max });
  }, [props.range?.[0], props.range?.[1], props.x]);
  useEffect(() => plot.current?.redraw(false), [props.bands]);
  return (
    <div
      ref={host}
      class="chart"
      role="group"
      tabIndex={0}
      aria-label={`${props.title}. Arrow keys move the cursor, plus and minus zoom, Shift and arrow keys move the range, 0 shows all.`}
      onKeyDown={(event) => plot.current && onKey(event, plot.current, props)}
    />
  );
}

export function fullRange(x: Float64Array): Range {
  return [x[0], x[x.length - 1]];
}

function create(element: HTMLElement, latest: { current: ChartProps }): uPlot {
  const { x, lines, log, limits, unit, height, range, sync } = latest.current;
  const many = lines.length > MANY;
  const ink = resolve("--soft");
  const grid = resolve("--grid");
  const gridOf = { stroke: grid, width: 1, ...(log && { filter: decades }) };
  const axis = { stroke: ink, font: "12px Plex, system-ui, sans-serif", grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1, size: 5 } };
  const [min, max] = range ?? fullRange(x);
  // Before the first drawing a plot has no range of its own yet.
  const inSight = (u: uPlot): Range => [u.scales.x.min ?? min, u.scales.x.max ?? max];
  const options: uPlot.Options = {
    width: element.clientWidth || 600,
    height,
    legend: { show: false },
    padding: [8, 28, 0, 0],
    scales: {
      x: { time: false, min, max, auto: false },
      y: { distr: log ? 3 : 1, range: (u, low, high) => limits ?? valueRange(latest.current, inSight(u), [low, high]) },
    },
    axes: [
      { ...axis, size: 30, gap: 4, values: (_u, values) => values.map((value, i) => (i === values.length - 1 ? `${value} Hz` : String(value))) },
      { ...axis, size: 62, label: unit, labelSize: 18, labelFont: axis.font, labelGap: 0, grid: gridOf, ticks: { show: false }, values: (_u, values) => values.map((v) => tickText(v, log)), ...(log && { filter: decades, splits: (_u, _axis, low, high) => logTicks(low, high) }) },
    ],
    series: [{}, ...(many ? [HIDDEN, HIDDEN] : lines.map(seriesOf))],
    cursor: {
      drag: { x: true, y: false, setScale: false, dist: 6 },
      points: { show: !many, size: 7 },
      // The cursor is shared, a dragged band is one plot's.
      ...(sync && { sync: { key: sync, setSeries: false, filters: { pub: (type: string) => type.startsWith("mousemove") || type === "mouseleave" } } }),
    },
    hooks: {
      drawAxes: [(u) => shade(u, latest.current)],
      drawSeries: [],
      draw: many ? [rasterLayer(lines, log ?? false)] : [],
      setSelect: [(u) => select(u, latest.current)],
      setCursor: [(u) => latest.current.onCursor?.(u.cursor.idx ?? null)],
    },
  };
  const data = [x, ...(many ? extremes(lines) : lines.map((line) => line.y))];
  const made = new uPlot(options, data as unknown as uPlot.AlignedData, element);
  made.over.addEventListener("wheel", (event) => onWheel(event, made, latest.current), { passive: false });
  made.over.addEventListener("dblclick", () => latest.current.setRange(null));
  made.root.setAttribute("aria-hidden", "true");
  return made;
}

const HIDDEN: uPlot.Series = { paths: () => null, points: { show: false } };

/** Return the highest and the lowest value of many curves line by line: all that the scales need of them. */
function extremes(lines: Line[]): [Float64Array, Float64Array] {
  const [high, low] = [lines[0].y.slice(), lines[0].y.slice()];
  for (const { y } of lines) {
    for (let i = 0; i < y.length; i++) {
      if (y[i] > high[i]) high[i] = y[i];
      if (y[i] < low[i]) low[i] = y[i];
    }
  }
  return [high, low];
}

function seriesOf(line: Line): uPlot.Series {
  return {
    stroke: resolve(line.tone),
    width: line.width ?? 1.5,
    dash: line.dash,
    points: { show: false },
    paths: (u, index) => ({ stroke: pathOf(u, line, u.series[index].scale ?? "y"), clip: undefined, band: undefined, gaps: undefined, flags: 0 }) as unknown as uPlot.Series.Paths,
  };
}

/** Return the path of a curve, every peak in it, broken where a value is missing. */
function pathOf(u: uPlot, line: Line, scale: string): Path2D {
  const { x, y } = line.own ?? { x: u.data[0] as unknown as Float64Array, y: line.y };
  const path = new Path2D();
  const { min, max } = u.scales.x;
  let pen = false;
  for (const i of thin(x, y, min!, max!, Math.max(1, Math.round(u.bbox.width)))) {
    const known = Number.isFinite(y[i]) && !(u.scales[scale].distr === 3 && y[i] <= 0);
    if (known) path[pen ? "lineTo" : "moveTo"](u.valToPos(x[i], "x", true), u.valToPos(y[i], scale, true));
    pen = known;
  }
  return path;
}

function rasterLayer(lines: Line[], log: boolean): (u: uPlot) => void {
  // Once, not each frame: a logarithm of a million values takes longer than all the rest.
  const level = (value: number) => (log ? Math.log10(value) : value);
  const groups = new Map<Float64Array | null, Float32Array[]>(); // by the frequencies that curves have in common
  for (const { y, own } of lines) {
    const [x, values] = own ? [own.x, own.y] : [null, y];
    groups.set(x, [...(groups.get(x) ?? []), Float32Array.from(values, level)]);
  }
  const layer = document.createElement("canvas");
  const colour = rgb("--ink");
  return (u) => {
    const { left, top, width, height } = u.bbox;
    if (width < 1 || height < 1) return;
    const { min, max } = u.scales.x;
    const window = { width, height, left: min!, right: max!, low: level(u.scales.y.min!), high: level(u.scales.y.max!) };
    if (layer.width !== width || layer.height !== height) [layer.width, layer.height] = [width, height];
    const context = layer.getContext("2d")!;
    const image = context.createImageData(width, height);
    const counts = new Uint16Array(width * height);
    for (const [own, levels] of groups) {
      const x = own ?? (u.data[0] as unknown as Float64Array);
      const begin = Math.max(0, firstAtLeast(x, min!) - 1);
      density(x, levels, window, begin, Math.min(x.length, firstAtLeast(x, max!) + 2), counts);
    }
    paint(counts, colour, image);
    context.putImageData(image, 0, 0);
    u.ctx.drawImage(layer, left, top);
  };
}

function shade(u: uPlot, { bands, envelope, x }: ChartProps): void {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.fillStyle = resolve("--band");
  for (const [low, high] of bands ?? []) {
    const from = u.valToPos(low, "x", true);
    ctx.fillRect(from, bbox.top, Math.max(2, u.valToPos(high, "x", true) - from), bbox.height);
  }
  if (envelope) {
    ctx.fillStyle = resolve("--noise");
    const path = new Path2D();
    const bottom = u.scales.y.min!;
    const at = (i: number, value: number) => path.lineTo(u.valToPos(x[i], "x", true), u.valToPos(Math.max(value, bottom), "y", true));
    for (let i = 0; i < x.length; i++) at(i, envelope.high[i]);
    for (let i = x.length - 1; i >= 0; i--) at(i, envelope.low[i]);
    ctx.fill(path);
  }
  ctx.restore();
}

function select(u: uPlot, props: ChartProps): void {
  if (u.select.width < 4) return;
  const band: Range = [u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")];
  u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  if (props.onBand) props.onBand(band);
  else props.setRange(band);
}

function onWheel(event: WheelEvent, u: uPlot, props: ChartProps): void {
  if (!event.ctrlKey && !event.shiftKey && Math.abs(event.deltaY) < Math.abs(event.deltaX)) return;
  event.preventDefault();
  const about = u.posToVal(event.offsetX, "x");
  zoom(u, props, about, event.deltaY > 0 ? 1.25 : 0.8);
}

function zoom(u: uPlot, props: ChartProps, about: number, factor: number): void {
  const { min, max } = u.scales.x;
  const [first, last] = fullRange(props.x);
  const low = Math.max(first, about - (about - min!) * factor);
  const high = Math.min(last, about + (max! - about) * factor);
  const spacing = (last - first) / Math.max(1, props.x.length - 1);
  if (high - low < 4 * spacing) return;
  props.setRange(low <= first && high >= last ? null : [low, high]);
}

function onKey(event: KeyboardEvent, u: uPlot, props: ChartProps): void {
  const { min, max } = u.scales.x;
  const way = event.key === "ArrowLeft" ? -1 : event.key === "ArrowRight" ? 1 : 0;
  if (way && event.shiftKey) {
    const [first, last] = fullRange(props.x);
    const step = way * 0.2 * (max! - min!);
    const shift = Math.min(Math.max(step, first - min!), last - max!);
    props.setRange([min! + shift, max! + shift]);
  } else if (way) {
    const visible = firstAtLeast(props.x, (min! + max!) / 2);
    const index = Math.min(props.x.length - 1, Math.max(0, (u.cursor.idx ?? visible) + way));
    u.setCursor({ left: u.valToPos(props.x[index], "x"), top: 10 });
  } else if (event.key === "+" || event.key === "=") zoom(u, props, cursorOr(u, (min! + max!) / 2), 0.7);
  else if (event.key === "-") zoom(u, props, cursorOr(u, (min! + max!) / 2), 1.4);
  else if (event.key === "0") props.setRange(null);
  else return;
  event.preventDefault();
}

function cursorOr(u: uPlot, middle: number): number {
  return u.cursor.left !== undefined && u.cursor.left! >= 0 ? u.posToVal(u.cursor.left!, "x") : middle;
}

/** Return the least value of curves above 0 Hz, where an inertance has none that a plot could show. */
export function floorOf(x: Float64Array, curves: Float64Array[]): number {
  let least = Infinity;
  for (const y of curves) for (let i = x[0] > 0 ? 0 : 2; i < y.length; i++) if (y[i] > 0 && y[i] < least) least = y[i];
  return least;
}
