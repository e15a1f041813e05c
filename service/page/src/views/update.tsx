/** Result of an update: coefficients by element, on the structure and as bars. */

import { useMemo, useRef, useState } from "preact/hooks";
import { projectionOf } from "../draw/projection";
import { Members } from "../draw/structure";
import { short, withError, words } from "../format";
import { type Geometry, geometry } from "../model";
import { Actions, csv, svgFile } from "../parts/actions";
import { Choice } from "../parts/fields";
import { go } from "../state";
import { useLoaded } from "../use";
import { type Iteration, Iterations } from "./iterations";

type ByMember = Record<string, number>;

export interface Update {
  id: string;
  kind: string;
  coefficients: Record<string, ByMember>;
  standard_errors: Record<string, ByMember>;
  suspected: Record<string, number[]>;
  frequencies: Record<string, number[]>;
  converged: boolean;
  stopped_because: string;
  identifiability: { directions: { words: string }[] } | null;
  structure_id: string;
  history?: Iteration[];
}

export function UpdateResult({ update, structureId, python }: { update: Update; structureId: string; python: () => string }) {
  const parts = Object.keys(update.coefficients ?? {}).filter((part) => Object.keys(update.coefficients[part]).length);
  const [part, setPart] = useState(parts.find((one) => update.suspected?.[one]?.length) ?? parts[0]);
  const drawn = useRef<SVGSVGElement>(null);
  const shape = useLoaded(`geometry/${structureId}`, () => geometry(structureId));
  if (!parts.length) return null;
  const coefficients = update.coefficients[part];
  const suspected = update.suspected?.[part] ?? [];
  return (
    <div class="update">
      <p class={update.converged ? "verdict" : "verdict diverged"}>{sentence(update, parts)}</p>
      <p class="hint">{update.converged && `The iteration converged: ${update.stopped_because}. `}Largest frequency difference {worst(update, "before")} before, {worst(update, "after")} after.</p>
      <div class="toolbar">
        <Choice label="Coefficients" value={part} set={setPart} options={parts.map((value) => ({ value, text: words(value) }))} />
        <Legend />
      </div>
      {shape.value && <Coloured svgRef={drawn} geometry={shape.value} coefficients={coefficients} label={`${part} coefficients on the structure`} />}
      <Bars coefficients={coefficients} errors={update.standard_errors?.[part] ?? {}} suspected={suspected} part={part} />
      <Iterations history={update.history ?? []} part={part} suspected={suspected} />
      <Actions
        python={python}
        downloads={[
          { text: "SVG", name: "coefficients.svg", from: () => svgFile(drawn.current!) },
          { text: "CSV", name: "coefficients.csv", from: () => csv({ member: Object.keys(coefficients).map(Number), [`${part} coefficient`]: Object.values(coefficients) }) },
        ]}
      />
      <NotDetermined words={(update.identifiability?.directions ?? []).map((direction) => direction.words)} />
      <p class="hint"><button type="button" class="action" onClick={() => go({ s: update.structure_id, u: undefined })}>Go on with the updated model</button></p>
    </div>
  );
}

const MOST_WORDS = 6;

function NotDetermined({ words: sentences }: { words: string[] }) {
  if (!sentences.length) return null;
  return (
    <details>
      <summary>What these modes do not determine <span class="count">{sentences.length}</span></summary>
      <ul class="located">{sentences.slice(0, MOST_WORDS).map((text) => <li>{text}</li>)}</ul>
    </details>
  );
}

function sentence(update: Update, parts: string[]): string {
  if (!update.converged) return `The update did not converge: ${update.stopped_because}.`;
  const named = parts.flatMap((part) => {
    const members = update.suspected?.[part] ?? [];
    const ranked = Object.entries(update.coefficients[part]).filter(([member]) => members.includes(Number(member)));
    ranked.sort((a, b) => Math.abs(Math.log(b[1])) - Math.abs(Math.log(a[1])));
    return ranked.slice(0, 1).map(([member, value]) => `${part} of member ${member} × ${withError(value, update.standard_errors?.[part]?.[member])}`);
  });
  return named.length ? `Most changed: ${named.join("; ")}.` : "No element has to change.";
}

function worst(update: Update, stage: string): string {
  const { measured } = update.frequencies;
  const at = update.frequencies[stage] ?? [];
  const differences = at.map((f, i) => Math.abs(f / measured[i] - 1)).filter(Number.isFinite);
  return differences.length ? `${short(100 * Math.max(...differences), 2)} %` : "–";
}

const STEPS = [0.7, 0.9, 0.97, 1.03, 1.1, 1.4];

/** Return the class of a coefficient, from far below 1 to far above. */
export function level(coefficient: number | undefined): string | undefined {
  if (coefficient === undefined) return undefined;
  return `level-${STEPS.filter((step) => coefficient > step).length}`;
}

function Legend() {
  return (
    <span class="level-legend" aria-label="From lower to higher than modelled">
      lower
      {STEPS.concat(2).map((_, i) => <i class={`level-${i}`} />)}
      higher
    </span>
  );
}

function Coloured({ geometry: shape, coefficients, label, svgRef }: { geometry: Geometry; coefficients: ByMember; label: string; svgRef: { current: SVGSVGElement | null } }) {
  const projection = useMemo(() => projectionOf(shape), [shape]);
  const height = projection.flat ? 90 : projection.height;
  const top = (projection.height - height) / 2;
  return (
    <svg ref={svgRef} class="shape" viewBox={`0 ${top} ${projection.width} ${height}`} role="img" aria-label={label}>
      <Members className="members coloured" geometry={shape} projection={projection} hue={(member) => level(coefficients[member])} />
    </svg>
  );
}

function Bars({ coefficients, errors, suspected, part }: { coefficients: ByMember; errors: ByMember; suspected: number[]; part: string }) {
  const members = Object.keys(coefficients).map(Number);
  const largest = Math.max(0.05, ...members.map((member) => Math.abs(coefficients[member] - 1) + (errors[member] ?? 0)));
  const [left, width, height] = [60, 920, 190];
  const step = width / members.length;
  const y = (value: number) => height / 2 - ((value - 1) / largest) * (height / 2 - 14);
  const every = Math.ceil(members.length / 24);
  return (
    <div class="drawing" tabIndex={0} role="region" aria-label={`Bars of the ${part} coefficients`}>
      <svg class="bars" viewBox={`0 0 1000 ${height + 30}`} role="img" aria-label={`${part} coefficients: ${members.map((member) => `member ${member} ${short(coefficients[member], 3)}`).join(", ")}`}>
        {[1 - largest, 1, 1 + largest].filter((value) => value >= 0).map((value) => (
          <g class="tick">
            <path d={`M${left} ${y(value)}H${left + width}`} />
            <text class="gap-label" x={left - 8} y={y(value) + 5}>{value.toFixed(2)}</text>
          </g>
        ))}
        {members.map((member, i) => {
          const x = left + (i + 0.5) * step;
          const value = coefficients[member];
          const error = errors[member] ?? 0;
          const wide = Math.min(26, step * 0.7);
          return (
            <g>
              <title>{`member ${member}: ${withError(value, errors[member])}`}</title>
              <rect class={level(value)} x={x - wide / 2} width={wide} y={Math.min(y(1), y(value))} height={Math.max(1.5, Math.abs(y(value) - y(1)))} />
              {error > 0 && <path class="error-bar" d={`M${x} ${y(value + error)}V${y(value - error)}`} />}
              {i % every === 0 && <text class={suspected.includes(member) ? "suspected" : ""} x={x} y={height + 20}>{member}</text>}
            </g>
          );
        })}
      </svg>
    </div>
  );
}
