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
}

/** Bars on a logarithmic scale that begins at 1, where only random error is left. */
export function GapByStep({ result }: { result: Diagnosis }) {
  const first = result.steps[0]?.gap_before ?? result.remaining_gap;
  const bars: Bar[] = [
    { label: "model and log book", gap: first },
    ...result.steps.map((step) => ({ label: `+ ${words(step.effect.kind)}`, gap: step.gap_after })),
  ];
  const decades = Math.max(1, Math.log10(Math.max(...bars.map((bar) => bar.gap))));
  const share = (gap: number) => Math.max(0.005, Math.log10(Math.max(gap, 1)) / decades);
  return (
    <figure class="gaps">
      <figcaption class="hint">Gap by step, on a logarithmic scale from 1: mean squared residual over its random variance. At 1 only random error is left.</figcaption>
      <dl>
        {bars.map((bar, i) => (
          <div class={i === 0 ? "gap before" : "gap"}>
            <dt>{bar.label}</dt>
            <dd>
              <i style={{ width: `${(78 * share(bar.gap)).toFixed(1)}%` }} />
              {short(bar.gap, 3)}
            </dd>
          </div>
        ))}
      </dl>
    </figure>
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
