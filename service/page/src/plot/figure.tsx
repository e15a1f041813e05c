/** A small plot of points and lines, of any abscissa. */

import { useRef } from "preact/hooks";
import { minus, power } from "../format";
import { Actions, svgFile } from "../parts/actions";

export interface Series {
  label: string;
  x: number[];
  y: number[];
  mark: "dots" | "line";
  /** Class that gives the colour. */
  tone: "ink" | "accent" | "warm" | "faint";
}

interface FigureProps {
  title: string;
  x: string;
  y: string;
  series: Series[];
  /** One scale for both axes: a circle is round. */
  equal?: boolean;
  /** Interval of the error at each abscissa. */
  band?: { x: number[]; low: number[]; high: number[] };
}

const [WIDTH, HEIGHT] = [330, 270];
const FRAME = { left: 52, right: 322, top: 10, bottom: 226 };

type Interval = [number, number];

export function Figure({ title, x, y, series, equal, band }: FigureProps) {
  const svg = useRef<SVGSVGElement>(null);
  let horizontal = extent(series.flatMap((one) => one.x));
  let vertical = extent([...series.flatMap((one) => one.y), ...(band?.low ?? []), ...(band?.high ?? [])]);
  if (equal) [horizontal, vertical] = alike(horizontal, vertical);
  const px = (value: number) => FRAME.left + ((value - horizontal[0]) / (horizontal[1] - horizontal[0])) * (FRAME.right - FRAME.left);
  const py = (value: number) => FRAME.bottom - ((value - vertical[0]) / (vertical[1] - vertical[0])) * (FRAME.bottom - FRAME.top);
  const path = (one: Series) => `M${one.x.map((value, i) => `${px(value).toFixed(1)} ${py(one.y[i]).toFixed(1)}`).join("L")}`;
  const named = series.filter((one) => one.label);
  return (
    <figure class="small-figure">
      <figcaption>{title}</figcaption>
      <svg ref={svg} viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={`${title}: ${y} over ${x}`}>
        <Axis interval={horizontal} place={px} title={x} across />
        <Axis interval={vertical} place={py} title={y} />
        {band && <path class="figure-band" d={`M${[...band.x.map((value, i) => [value, band.high[i]]), ...band.x.map((value, i) => [value, band.low[i]]).reverse()].map(([a, b]) => `${px(a).toFixed(1)} ${py(b).toFixed(1)}`).join("L")}Z`} />}
        {series.map((one) =>
          one.mark === "line"
            ? <path class={`figure-line ${one.tone}`} d={one.x.length ? path(one) : ""} />
            : one.x.map((value, i) => <circle class={`figure-dot ${one.tone}`} cx={px(value).toFixed(1)} cy={py(one.y[i]).toFixed(1)} r="3" />),
        )}
      </svg>
      <div class="figure-foot">
        {named.map((one) => <span class="inline"><i class={`swatch figure-${one.mark} ${one.tone}`} /> {one.label}</span>)}
        <Actions downloads={[{ text: "SVG", name: `${title.toLowerCase().replaceAll(/[^a-z]+/g, "-")}.svg`, from: () => svgFile(svg.current!) }]} />
      </div>
    </figure>
  );
}

function Axis({ interval, place, title, across }: { interval: Interval; place(value: number): number; title: string; across?: boolean }) {
  const largest = Math.max(...interval.map(Math.abs));
  const shift = largest >= 1e4 || largest < 1e-2 ? 3 * Math.floor(Math.log10(largest) / 3) : 0;
  const [name, unit = ""] = title.split(", ");
  const words = shift ? `${name}, ${power(shift)} ${unit}` : title;
  const middle = (FRAME.top + FRAME.bottom) / 2;
  return (
    <g class="figure-axis">
      {ticks(interval, across ? 4 : 5).map((value) => {
        const at = place(value).toFixed(1);
        return (
          <g>
            <path d={across ? `M${at} ${FRAME.top}V${FRAME.bottom}` : `M${FRAME.left} ${at}H${FRAME.right}`} />
            <text class={across ? "" : "end"} x={across ? at : FRAME.left - 6} y={across ? FRAME.bottom + 16 : Number(at) + 4}>{minus(String(Number((value / 10 ** shift).toPrecision(6))))}</text>
          </g>
        );
      })}
      <text x={across ? (FRAME.left + FRAME.right) / 2 : 0} y={across ? HEIGHT - 8 : 0} transform={across ? undefined : `translate(11 ${middle}) rotate(-90)`}>{words}</text>
    </g>
  );
}

function extent(values: number[]): Interval {
  const known = values.filter(Number.isFinite);
  if (!known.length) return [0, 1];
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const margin = 0.06 * (high - low || Math.abs(high) || 1);
  return [low - margin, high + margin];
}

/** Return both intervals widened so that a unit is as long on either axis. */
function alike(horizontal: Interval, vertical: Interval): [Interval, Interval] {
  const unit = Math.max((horizontal[1] - horizontal[0]) / (FRAME.right - FRAME.left), (vertical[1] - vertical[0]) / (FRAME.bottom - FRAME.top));
  const widened = ([low, high]: Interval, length: number): Interval => [(low + high - unit * length) / 2, (low + high + unit * length) / 2];
  return [widened(horizontal, FRAME.right - FRAME.left), widened(vertical, FRAME.bottom - FRAME.top)];
}

/** Return round values inside an interval, about `count` of them. */
export function ticks([low, high]: Interval, count: number): number[] {
  const rough = (high - low) / count;
  const size = 10 ** Math.floor(Math.log10(rough));
  const step = size * ([1, 2, 5].find((factor) => factor * size >= rough) ?? 10);
  const first = Math.ceil(low / step);
  const last = Math.floor(high / step);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}
