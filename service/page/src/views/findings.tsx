/** What a diagnosis found: effects with their size, the gap by step, and the candidates. */

import { percent, placeText, short, withError, words } from "../format";
import type { Diagnosis, Rival, Step } from "../model";

export function StepList({ steps }: { steps: Step[] }) {
  return (
    <ol class="steps-found">
      {steps.map((step) => (
        <li>
          <h2>{`${words(step.effect.kind)} ${placeText(step.effect.at)}`}</h2>
          <dl>
            {Object.entries(step.effect.parameters).map(([name, parameter]) => (
              <div>
                <dt>{words(name)}</dt>
                <dd>{withError(parameter.value, parameter.standard_error)} {parameter.unit === "1" ? "" : parameter.unit}</dd>
              </div>
            ))}
            <div>
              <dt>probability</dt>
              <dd>{percent(step.probability)}</dd>
            </div>
            <div>
              <dt>gap</dt>
              <dd>{short(step.gap_before, 3)} → {short(step.gap_after, 3)}</dd>
            </div>
            {step.held_out_gap_after !== null && (
              <div>
                <dt>on FRFs kept out</dt>
                <dd>{short(step.held_out_gap_before, 3)} → {short(step.held_out_gap_after, 3)}</dd>
              </div>
            )}
          </dl>
          {step.rivals_alike.length > 0 && <p class="hint">This test cannot tell it from {step.rivals_alike.map((rival) => `${words(rival.kind)} ${placeText(rival.at)}`).join(" or ")}.</p>}
        </li>
      ))}
    </ol>
  );
}

interface Bar {
  label: string;
  gap: number;
  /** Without what was found. */
  before?: boolean;
  /** Of FRFs that were kept out of every fit. */
  keptOut?: boolean;
  words?: string;
}

/** Bars on a logarithmic scale that begins at 1, where only random error is left. */
export function GapBars({ caption, bars, most }: { caption: string; bars: Bar[]; most: number }) {
  const decades = Math.max(1, Math.log10(most));
  const share = (gap: number) => Math.max(0.005, Math.log10(Math.max(gap, 1)) / decades);
  return (
    <figure class="gaps">
      <figcaption class="hint">{caption}</figcaption>
      <dl>
        {bars.map((bar) => (
          <div class={`gap${bar.before ? " before" : ""}${bar.keptOut ? " kept-out" : ""}`}>
            <dt>{bar.label}</dt>
            <dd>
              <i style={{ width: `${(72 * share(bar.gap)).toFixed(1)}%` }} />
              {bar.words ?? short(bar.gap, 3)}
            </dd>
          </div>
        ))}
      </dl>
    </figure>
  );
}

export function GapByStep({ result: { steps, remaining_gap: remaining } }: { result: Diagnosis }) {
  const keptOut = (gap: number | null | undefined, before = false): Bar[] =>
    gap === null || gap === undefined ? [] : [{ label: "FRFs kept out", gap, before, keptOut: true }];
  const bars: Bar[] = [
    { label: "model and log book", gap: steps[0]?.gap_before ?? remaining, before: true },
    ...keptOut(steps[0]?.held_out_gap_before, true),
    ...steps.flatMap((step) => [{ label: `+ ${words(step.effect.kind)}`, gap: step.gap_after }, ...keptOut(step.held_out_gap_after)]),
  ];
  const caption = "Gap by step, on a logarithmic scale from 1: mean squared residual over its random variance. At 1 only random error is left.";
  return <GapBars caption={caption} bars={bars} most={Math.max(...bars.map((bar) => bar.gap))} />;
}

/** Rivals of each named effect: what else was compared with it, how probable that is, and what it leaves. */
export function RivalTable({ steps }: { steps: Step[] }) {
  const rows = steps.flatMap((step) => step.rivals.map((rival) => ({ step, rival })));
  if (!rows.length) return null;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Table of rivals">
      <table>
        <caption>Rivals of what was named</caption>
        <thead>
          <tr>
            <th scope="col" class="text">In place of</th>
            <th scope="col" class="text">Rival</th>
            <th scope="col">Probability</th>
            <th scope="col">Gap left</th>
          </tr>
        </thead>
        <tbody>
          {rows.slice(0, 12).map(({ step, rival }) => (
            <tr>
              <td class="text">{`${words(step.effect.kind)} ${placeText(step.effect.at)}`}</td>
              <td class="text">{`${words(rival.kind)} ${placeText(rival.at)}`}</td>
              <td>{percent(rival.probability)}</td>
              <td>{short(rival.gap_after, 3)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function CandidateTable({ candidates }: { candidates: Rival[] }) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Table of candidates">
      <table>
        <caption>What was tried first, and how well it explains the test</caption>
        <thead>
          <tr>
            <th scope="col" class="text">Effect</th>
            <th scope="col" class="text">Place</th>
            <th scope="col">Probability</th>
            <th scope="col">Gap left</th>
          </tr>
        </thead>
        <tbody>
          {candidates.slice(0, 8).map((rival) => (
            <tr>
              <td class="text">{words(rival.kind)}</td>
              <td class="text">{placeText(rival.at)}</td>
              <td>{percent(rival.probability)}</td>
              <td>{short(rival.gap_after, 3)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
