/** The fits of one mode in one FRF, by every method at once: its plot, what it leaves, its standard errors. */

import { useState } from "preact/hooks";
import { short, withError, words } from "../format";
import { type Complex, type Fit, loadFit, misfit } from "../fit";
import type { ModalModel, Mode } from "../model";
import { Actions, csv } from "../parts/actions";
import { SelectField } from "../parts/fields";
import { Loading, ProblemNote } from "../parts/notes";
import { useLoaded } from "../use";
import { FitFigures } from "./fit-figures";

interface Fitted {
  fit: Fit;
  mode: Mode;
}

export function FitPanel({ models, frequency }: { models: ModalModel[]; frequency: number }) {
  const [{ dofs, references }] = models;
  const [response, setResponse] = useState(dofs[0]);
  const [reference, setReference] = useState(references[0]);
  const key = `fits/${models.map((model) => model.id)}/${frequency}/${response}/${reference}`;
  const loaded = useLoaded(key, () => Promise.all(models.map((model) => fitNear(model, frequency, response, reference))));
  return (
    <section class="fits" aria-labelledby="fits-title">
      <div class="toolbar">
        <h2 id="fits-title">Fits of the mode</h2>
        <SelectField label="Response" value={response} set={setResponse} options={dofs.map((value) => ({ value, text: value }))} />
        {references.length > 1 && <SelectField label="Reference" value={reference} set={setReference} options={references.map((value) => ({ value, text: value }))} />}
      </div>
      {loaded.problem && <ProblemNote problem={loaded.problem} />}
      {loaded.loading && <Loading what="the fits" />}
      {loaded.value && (
        <>
          <div class="figures">{loaded.value.map(({ fit }) => <FitFigures fit={fit} />)}</div>
          <FitTable fits={loaded.value} />
          <Actions downloads={[{ text: "CSV", name: "fits.csv", from: () => csv(Object.assign({}, ...loaded.value!.map(({ fit }) => columnsOf(fit)))) }]} />
        </>
      )}
    </section>
  );
}

/** Return the fit of the mode of a model that is nearest to a frequency. */
async function fitNear(model: ModalModel, frequency: number, response: string, reference?: string): Promise<Fitted> {
  const distance = (mode: Mode) => Math.abs(mode.frequency - frequency);
  const index = model.modes.reduce((best, mode, i) => (distance(mode) < distance(model.modes[best]) ? i : best), 0);
  return { fit: await loadFit(model.id, index + 1, response, reference), mode: model.modes[index] };
}

function FitTable({ fits }: { fits: Fitted[] }) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Table of fits">
      <table>
        <caption>Residual: rms of what the fit leaves of its lines, over that of the lines. Means have their standard errors in brackets.</caption>
        <thead>
          <tr>
            <th scope="col" class="text">Method</th>
            <th scope="col">Frequency, Hz</th>
            <th scope="col">Mean, Hz</th>
            <th scope="col">Loss factor</th>
            <th scope="col">Mean</th>
            <th scope="col">Residual</th>
            <th scope="col" class="text">Quality</th>
          </tr>
        </thead>
        <tbody>
          {fits.map(({ fit, mode }) => (
            <tr>
              <td class="text">{words(fit.method)}</td>
              <td>{short(fit.frequency, 6)}</td>
              <td>{withError(mode.frequency, mode.standard_errors.frequency)}</td>
              <td>{short(fit.loss_factor, 4)}</td>
              <td>{withError(mode.loss_factor, mode.standard_errors.loss_factor)}</td>
              <td>{short(100 * misfit(fit), 2)} %</td>
              <td class="text">{Object.entries(fit.quality).map(([name, value]) => `${words(name)} ${short(value, 2)} %`).join(", ") || "–"}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function columnsOf(fit: Fit): Record<string, ArrayLike<number | string | null>> {
  const named = (name: string) => `${fit.method} ${name}`;
  const part = (values: Complex[], k: 0 | 1) => values.map((value) => value[k]);
  return {
    [named("frequency, Hz")]: fit.freq,
    [named("used")]: fit.used.map(Number),
    [named("measured real")]: part(fit.measured, 0),
    [named("measured imaginary")]: part(fit.measured, 1),
    [named("without other modes real")]: part(fit.cleaned, 0),
    [named("without other modes imaginary")]: part(fit.cleaned, 1),
    [named("curve, Hz")]: fit.curve_freq,
    [named("curve real")]: part(fit.curve, 0),
    [named("curve imaginary")]: part(fit.curve, 1),
  };
}
