/** The plot of each method: circle and damping surface, straight lines, difference quotients. */

import { short, words } from "../format";
import type { Complex, Fit } from "../fit";
import { Figure, type Series } from "../plot/figure";

export function FitFigures({ fit }: { fit: Fit }) {
  const Drawn = FIGURES[fit.method];
  // Too few lines for the plot of the method: the response itself is always there.
  return Drawn && Object.keys(fit.details).length ? <Drawn fit={fit} /> : <Nyquist fit={fit} />;
}

const FIGURES: Partial<Record<string, (props: { fit: Fit }) => preact.JSX.Element>> = {
  circle_fit: CircleFit,
  line_fit: LineFit,
  dobson: Dobson,
  linear_fit: LinearFit,
  peak_picking: PeakPicking,
};

const real = (values: unknown) => (values as Complex[]).map(([re]) => re);
const imaginary = (values: unknown) => (values as Complex[]).map(([, im]) => im);

/** Return the abscissa of a method and its name: with viscous damping it is omega. */
const abscissa = ({ damping }: Fit) => (damping === "viscous" ? "ω, rad/s" : "ω², (rad/s)²");

const dots = (label: string, x: number[], y: number[], tone: Series["tone"] = "accent"): Series => ({ label, x, y, mark: "dots", tone });
const line = (label: string, x: number[], y: number[], tone: Series["tone"] = "ink"): Series => ({ label, x, y, mark: "line", tone });

function Nyquist({ fit }: { fit: Fit }) {
  const series = [line("fit", real(fit.curve), imaginary(fit.curve)), dots("lines", real(fit.cleaned), imaginary(fit.cleaned))];
  return <Figure title={`${words(fit.method)}: Nyquist plot`} x="Re" y="Im" equal series={series} />;
}

function CircleFit({ fit }: { fit: Fit }) {
  const { circle, points, resonance } = fit.complex_details;
  const series = [
    line("circle", real(circle), imaginary(circle)),
    dots("lines", real(points), imaginary(points)),
    dots("resonance", real(resonance), imaginary(resonance), "warm"),
  ];
  return (
    <>
      <Figure title="circle fit: circle" x="Re" y="Im" equal series={series} />
      <DampingSurface fit={fit} />
    </>
  );
}

/** Both parts of complex values over the abscissa, each with its straight line. */
function straight(x: number[], points: unknown, lines: unknown): Series[] {
  return [
    line("", x, real(lines)),
    line("", x, imaginary(lines)),
    dots("real", x, real(points)),
    dots("imaginary", x, imaginary(points), "warm"),
  ];
}

function LineFit({ fit }: { fit: Fit }) {
  const { inverse, line: fittedLine } = fit.complex_details;
  return <Figure title="line fit: inverse of the response" x={abscissa(fit)} y="1/(H − R)" series={straight(fit.details.x as number[], inverse, fittedLine)} />;
}

function Dobson({ fit }: { fit: Fit }) {
  const { x, x_delta: over } = fit.details as { x: number[]; x_delta: number[][] };
  const { delta, delta_lines: fans, slopes, slope_line: slopeLine } = fit.complex_details;
  const fan = [
    ...over.map((row, i) => line("", row, real(fans[i]), "faint")),
    ...over.map((row, i) => dots(i ? "" : "Re Δ, a line for each reference", row, real(delta[i]))),
  ];
  return (
    <>
      <Figure title="Dobson: difference quotients" x={abscissa(fit)} y="Re Δ" series={fan} />
      <Figure title="Dobson: slopes over the reference" x={abscissa(fit)} y="slope" series={straight(x, slopes, slopeLine)} />
    </>
  );
}

function LinearFit({ fit }: { fit: Fit }) {
  const { left, right } = fit.complex_details;
  return <Figure title="linear fit: both sides" x={abscissa(fit)} y="α ω²" series={straight(fit.details.x as number[], left, right)} />;
}

function PeakPicking({ fit }: { fit: Fit }) {
  const at = (name: string) => fit.details[name] as number[];
  const series = [line("magnitude", at("x"), at("magnitude")), dots("peak", at("x_peak"), at("peak")), dots("half power", at("x_half"), at("half"), "warm")];
  return <Figure title="peak picking" x={abscissa(fit)} y="magnitude" series={series} />;
}

/** Loss factor of every pair of a line below and a line above resonance: level where one mode is alone. */
function DampingSurface({ fit }: { fit: Fit }) {
  const surface = fit.details.damping_surface as number[][];
  const hertz = (x: number) => short((fit.damping === "viscous" ? x : Math.sqrt(x)) / (2 * Math.PI), 5);
  const [above, below] = ["x_above", "x_below"].map((name) => (fit.details[name] as number[]).map(hertz));
  const values = surface.flat();
  if (!values.length) return <></>;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const [width, height] = [270 / below.length, 216 / above.length];
  return (
    <figure class="small-figure">
      <figcaption>circle fit: damping surface</figcaption>
      <svg viewBox="0 0 330 270" role="img" aria-label={`Loss factor of ${values.length} pairs of lines, ${short(low)} to ${short(high)}`}>
        {surface.map((row, i) =>
          row.map((value, j) => (
            <rect class="surface-cell" x={52 + j * width} y={10 + i * height} width={width - 1} height={height - 1} opacity={0.08 + (0.92 * (value - low)) / (high - low || 1)}>
              <title>{`${below[j]} and ${above[i]} Hz: ${short(value)}`}</title>
            </rect>
          )),
        )}
        <g class="figure-axis">
          {[0, below.length - 1].map((j) => <text x={52 + (j + 0.5) * width} y="242">{below[j]}</text>)}
          {[0, above.length - 1].map((i) => <text class="end" x="48" y={14 + (i + 0.5) * height}>{above[i]}</text>)}
          <text x="187" y="262">line below, Hz</text>
          <text transform="translate(11 118) rotate(-90)">line above, Hz</text>
        </g>
      </svg>
      <div class="figure-foot">loss factor {short(low)} (pale) to {short(high)}</div>
    </figure>
  );
}
