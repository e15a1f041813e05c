/** View 4: measured modes against the model's, and the model corrected by them. */

import { useCallback, useState } from "preact/hooks";
import { get, post } from "../api";
import { catalogue, structure } from "../model";
import { Group, SelectField, StartButton } from "../parts/fields";
import { Empty, Loading, ProblemNote, WorkNote } from "../parts/notes";
import { literal, program } from "../python";
import { type State, address, go } from "../state";
import { useLoaded, useWork } from "../use";
import { NoTest, loadModes } from "./extract";
import { MacMatrix, type Correlation, PairTable } from "./mac";
import { type Update, UpdateResult } from "./update";

// Those that give a coefficient for every element, which can be coloured on the structure.
const BY_ELEMENT = ["inverse_eigensensitivity", "one_shot", "complex_inverse_eigensensitivity", "complex_one_shot"];

export function CorrelateView({ state }: { state: State }) {
  const about = useLoaded(state.s ? `structure/${state.s}` : null, () => structure(state.s!));
  const modes = useLoaded(state.x ? `modes/${state.x}` : null, () => loadModes(state.x!));
  const ready = state.s !== undefined && state.x !== undefined;
  const request = { modal_model_id: state.x, structure_id: state.s };
  const correlated = useLoaded(ready ? `correlation/${state.s}/${state.x}` : null, () => post<Correlation>("/correlations", request));
  const update = useLoaded(state.u ? `update/${state.u}` : null, () => get<Update>(`/updates/${state.u}`));
  const methods = useLoaded("catalogue/updating-methods", () => catalogue("updating-methods"));
  const [method, setMethod] = useState(BY_ELEMENT[0]);
  const work = useWork(useCallback((id: string) => go({ u: id }), []));
  if (!state.t.length && !state.x) return <NoTest state={state} />;
  if (!ready) return <NoModes state={state} />;
  const python = () =>
    program([
      `seen = lab.correlations.create(${literal(state.x)}, ${literal(state.s)})`,
      "print(seen.pairs, seen.frequency_differences)",
      `update = lab.updates.start(${literal(state.s)}, ${literal(state.x)}, method=${literal(method)}).result()`,
      "print(update.suspected, update.coefficients)",
    ]);
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="correlate-title">
        <div class="stage-head">
          <h1 id="correlate-title">Correlation</h1>
          <p class="facts">Measured modes against those of {about.value?.name || "the model"}.</p>
        </div>
        <WorkNote work={work} what="update" />
        {update.problem && <ProblemNote problem={update.problem} again={() => go({ u: undefined })} />}
        {update.value && <UpdateResult update={update.value} structureId={state.s!} python={python} />}
        {correlated.problem && <ProblemNote problem={correlated.problem} />}
        {(correlated.loading || modes.loading) && <Loading what="the comparison" />}
        {correlated.value && modes.value && (
          <div class="side-by-side">
            <MacMatrix mac={correlated.value.mac} />
            <PairTable correlation={correlated.value} measured={modes.value.model.modes.map((mode) => mode.frequency)} python={update.value ? undefined : python} />
          </div>
        )}
      </section>
      <aside class="panel" aria-label="Update">
        <Group title="Correct the model">
          <SelectField label="Method" value={method} set={setMethod} options={BY_ELEMENT.map((value) => ({ value, hint: methods.value?.find((entry) => entry.kind === value)?.summary }))} />
          <p class="hint">{methods.value?.find((entry) => entry.kind === method)?.summary}</p>
          <StartButton busy={work.busy} start={() => work.start("/updates", { ...request, method })}>{work.busy ? "Updating …" : "Update the model"}</StartButton>
        </Group>
        <a class="next" href={address({ ...state, view: "diagnose" })}>Diagnose</a>
      </aside>
    </div>
  );
}

function NoModes({ state }: { state: State }) {
  return (
    <section class="stage">
      <Empty title="No modes yet">
        <p>This step compares measured modes with those of a model.</p>
        <a class="next" href={address({ ...state, view: state.s ? "extract" : "rig" })}>{state.s ? "Extract modes" : "Choose a model"}</a>
      </Empty>
    </section>
  );
}
