/** Import of the files of a test. */

import { useState } from "preact/hooks";
import { type Problem, upload } from "../api";
import type { Measurement } from "../model";
import { DropZone } from "../parts/dropzone";
import { ProblemNote } from "../parts/notes";
import { asProblem } from "../use";

export function ImportZone({ taken }: { taken(id: string): void }) {
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const take = (files: File[]) => {
    const form = new FormData();
    for (const file of files) form.append("file", file);
    setBusy(true);
    setProblem(null);
    upload<Measurement>("/measurements/import", form)
      .then((made) => taken(made.id), (error) => setProblem(asProblem(error)))
      .finally(() => setBusy(false));
  };
  return (
    <>
      <DropZone label="Drop FRFs here, or choose files" hint="Universal file 58, npz, HDF5, MATLAB, text, zip" take={take} busy={busy} />
      {problem && <ProblemNote problem={problem} />}
    </>
  );
}
