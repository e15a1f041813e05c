/** An effect of no catalogue: its curve with the law that it follows, and its adoption into the model. */

import { useMemo, useState } from "preact/hooks";
import { post } from "../api";
import { placeText, short, withError, words } from "../format";
import { column } from "../frf";
import type { Diagnosis, Unknown } from "../model";
import type { Arrays } from "../npz";
import { Actions, csv } from "../parts/actions";
import { ProblemNote } from "../parts/notes";
import { Figure, type Series } from "../plot/figure";
import { literal, program } from "../python";
import { useActions } from "../use";
import { GapBars } from "./findings";

interface Adoption {
  structure_id: string;
  rig_id: string;
  kind: string;
}

interface UnknownProps {
  result: Diagnosis;
  unknown: Unknown;
  curves: Arrays;
  /** Go on with the model that has the effect. */
  goOn(structureId: string): void;
}

const WIDTH_OF_BAND = 2; // standard errors

export function UnknownEffect({ result, unknown, curves, goOn }: UnknownProps) {
  const [adopted, setAdopted] = useState<Adoption | null>(null);
  const { run, busy, problem } = useActions();
  const parts = useMemo(() => partsOf(curves, unknown), [curves, unknown]);
  const adopt = async () => setAdopted(await post<Adoption>(`/diagnoses/${result.id}/adopt`, {}));
  const quantity = unknown.cause === "internal_force" ? "dynamic stiffness" : "gain";
  const unit = unknown.unit === "1" ? "" : `, ${unknown.unit}`;
  return (
    <section class="unknown" aria-labelledby="unknown-title">
      <h2 id="unknown-title">{`${causeWords(unknown)}: an effect of no catalogue`}</h2>
      <p>{lawWords(unknown)}</p>
      {unknown.rivals_alike.length > 0 && <p class="hint">This test cannot tell it from {unknown.rivals_alike.map(causeWords).join(" or ")}.</p>}
      <div class="figures wide-figures">
        {parts.map(({ name, series, band }) => <Figure title={`${quantity}, ${name} part`} x="frequency, Hz" y={`${name}${unit}`} series={series} band={band} />)}
      </div>
      <p class="hint">Grey: two standard errors about the curve, which was solved for line by line.</p>
      <Gaps unknown={unknown} adopted={adopted !== null} />
      {adopted ? (
        <p class="notice" role="status">
          <span>Adopted as a {words(adopted.kind)}: the model has it now.</span>
          <button type="button" onClick={() => goOn(adopted.structure_id)}>Diagnose with it</button>
        </p>
      ) : (
        <p><button type="button" disabled={busy} onClick={() => run(adopt)}>Adopt it</button></p>
      )}
      {problem && <ProblemNote problem={problem} />}
      <Actions
        python={() => program([`adopted = lab.diagnoses.adopt(${literal(result.id)})`, "print(adopted.structure_id, adopted.rig_id)"])}
        downloads={[{ text: "CSV", name: "unknown.csv", from: () => csv(tableOf(curves)) }]}
      />
    </section>
  );
}

/** Gaps without the effect, and with it once it is adopted. */
function Gaps({ unknown, adopted }: { unknown: Unknown; adopted: boolean }) {
  const rows = [
    { label: "fitted FRFs", before: unknown.gap_before, after: unknown.gap_after },
    { label: "FRFs kept out", before: unknown.held_out_gap_before, after: unknown.held_out_gap_after },
  ].filter((row) => row.before !== null && row.after !== null);
  const most = Math.max(...rows.map((row) => row.before!));
  return (
    <GapBars
      caption={adopted ? "Gap with the adopted effect, on a logarithmic scale from 1" : "Gap without the effect, on a logarithmic scale from 1"}
      most={most}
      bars={rows.map(({ label, before, after }) => ({ label, gap: adopted ? after! : before!, before: !adopted, words: adopted ? `${short(before, 3)} → ${short(after, 3)}` : undefined }))}
    />
  );
}

const causeWords = ({ cause, at }: Pick<Unknown, "cause" | "at">): string =>
  cause === "internal_force" ? `unknown force ${placeText(at)}` : cause === "channel_gain" ? `unknown gain of ${placeText(at)}` : "unknown gain of all channels, or force at the drive point";

function lawWords({ curve_model: model, parameters, source, at }: Unknown): string {
  if (model === null) return "Its curve follows none of the laws that were tried.";
  const values = Object.entries(parameters).map(([name, { value, standard_error: error, unit }]) => `${words(name)} ${withError(value, error)}${unit === "1" ? "" : ` ${unit}`}`);
  const driven = source !== null && source !== at ? `, driven by the motion of ${source}` : "";
  return `Its law is that of: ${words(model)}${driven}; ${values.join(", ")}.`;
}

interface Part {
  name: string;
  series: Series[];
  band: { x: number[]; low: number[]; high: number[] };
}

function partsOf(curves: Arrays, { curve_model: model }: Unknown): Part[] {
  const x = Array.from(curves["unknown.freq"].values as Float64Array);
  const lines = Array.from(curves.freq.values as Float64Array);
  const error = curves["unknown.error"].values as Float64Array;
  const values = column(curves, "unknown.value", 0);
  const law = curves["unknown.model"] && column(curves, "unknown.model", 0);
  return ["real", "imaginary"].map((name, k) => {
    const y = Array.from(values[k]);
    const side = (sign: number) => y.map((value, i) => value + sign * WIDTH_OF_BAND * (Number.isFinite(error[i]) ? error[i] : 0));
    const dots: Series = { label: "solved for", x, y, mark: "dots", tone: "accent" };
    const line: Series[] = law && model ? [{ label: words(model), x: lines.slice(1), y: Array.from(law[k]).slice(1), mark: "line", tone: "warm" }] : [];
    return { name, series: [...line, dots], band: { x, low: side(-1), high: side(1) } };
  });
}

function tableOf(curves: Arrays): Record<string, ArrayLike<number>> {
  const [real, imaginary] = column(curves, "unknown.value", 0);
  return {
    "frequency, Hz": curves["unknown.freq"].values as Float64Array,
    real,
    imaginary,
    "standard error": curves["unknown.error"].values as Float64Array,
  };
}
