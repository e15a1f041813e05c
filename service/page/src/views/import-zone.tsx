/** Import of the files of a test. */

import { upload } from "../api";
import type { Measurement } from "../model";
import { DropZone } from "../parts/dropzone";
import { ProblemNote } from "../parts/notes";
import { useActions } from "../use";

export function ImportZone({ taken }: { taken(id: string): void }) {
  const { run, busy, problem } = useActions();
  const take = (files: File[]) => {
    const form = new FormData();
    for (const file of files) form.append("file", file);
    run(async () => taken((await upload<Measurement>("/measurements/import", form)).id));
  };
  return (
    <>
      <DropZone label="Drop FRFs here, or choose files" hint="Universal file 58, npz, HDF5, MATLAB, text, zip" take={take} busy={busy} />
      {problem && <ProblemNote problem={problem} />}
    </>
  );
}
