/** The signals that the FRFs of a test are made of, for one response: a time record, and auto spectra. */

import { useState } from "preact/hooks";
import { arrays } from "../api";
import type { Measurement } from "../model";
import { SelectField } from "../parts/fields";
import { Loading, ProblemNote } from "../parts/notes";
import { Figure, type Series } from "../plot/figure";
import { type Trace, recordsOf, spectraOf } from "../signals";
import { useLoaded } from "../use";

export function SignalPanel({ test }: { test: Measurement }) {
  const [open, setOpen] = useState(false);
  return (
    <details class="signals" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>Time record and spectra</summary>
      {open && <Signals test={test} />}
    </details>
  );
}

async function load({ id, n_records: kept }: Measurement) {
  const [spectra, records] = await Promise.all([arrays(`/measurements/${id}/arrays`), kept ? arrays(`/measurements/${id}/records`) : null]);
  return { spectra, records };
}

function Signals({ test }: { test: Measurement }) {
  const [response, setResponse] = useState(test.outputs[0]);
  const loaded = useLoaded(`signals/${test.id}`, () => load(test));
  if (loaded.problem) return <ProblemNote problem={loaded.problem} />;
  if (!loaded.value) return <Loading what="the signals" />;
  const spectra = spectraOf(loaded.value.spectra, response);
  const records = loaded.value.records && recordsOf(loaded.value.records, response);
  return (
    <>
      <div class="toolbar"><SelectField label="Response of the signals" value={response} set={setResponse} options={test.outputs.map((value) => ({ value, text: value }))} /></div>
      <div class="figures">
        {records && <Figure title="Force, first record" x="time, s" y="force, N" series={line(records.force, "warm")} />}
        {records && <Figure title={`Response ${response}, first record`} x="time, s" y="acceleration, m/s²" series={line(records.response, "accent")} />}
        {spectra && <Figure title="Auto spectrum of the force" x="frequency, Hz" y="level, dB re 1 N²/Hz" series={line(spectra.force, "warm")} />}
        {spectra && <Figure title={`Auto spectrum of ${response}`} x="frequency, Hz" y="level, dB re 1 (m/s²)²/Hz" series={line(spectra.response, "accent")} />}
      </div>
      {!records && <p class="hint">No time record of this response was kept.</p>}
      {!spectra && <p class="hint">This test came without auto spectra.</p>}
    </>
  );
}

const line = (trace: Trace, tone: Series["tone"]): Series[] => [{ label: "", ...trace, mark: "line", tone }];
