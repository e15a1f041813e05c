/** Choice of the structure: an example, a beam of one's own, or a file. */

import { useEffect, useRef, useState } from "preact/hooks";
import { type Problem, ProblemError, post, upload } from "../api";
import type { CatalogueEntry, Structure } from "../model";
import { DropZone } from "../parts/dropzone";
import { Choice, Group, NumberField, SelectField } from "../parts/fields";
import { ProblemNote } from "../parts/notes";
import { go } from "../state";
import { asProblem } from "../use";

type Origin = "example" | "beam" | "file";

export function StructurePanel({ current, known }: { current: Structure; known: CatalogueEntry[] }) {
  const example = known.some((entry) => entry.kind === current.name);
  const [origin, setOrigin] = useState<Origin>("example");
  const [problem, setProblem] = useState<Problem | null>(null);
  const [wanted, setWanted] = useState<string | null>(null); // an example that is on its way
  const turn = useRef(0); // letters and arrow keys choose one example after another: the last one counts
  const make = (promise: Promise<Structure>) => {
    const mine = ++turn.current;
    setProblem(null);
    promise.then(
      (made) => mine === turn.current && go({ s: made.id, rig: undefined, t: [], x: undefined, u: undefined, d: undefined }),
      (error) => {
        if (mine !== turn.current) return;
        setProblem(asProblem(error));
        setWanted(null);
      },
    );
  };
  useEffect(() => {
    if (wanted === current.name) setWanted(null);
  }, [current.id]);
  return (
    <Group title="Structure">
      <Choice<Origin>
        label="Origin of the structure"
        value={origin}
        set={(next) => setOrigin(next)}
        options={[{ value: "example", text: "Example" }, { value: "beam", text: "Beam" }, { value: "file", text: "File" }]}
      />
      {origin === "example" && (
        <>
          <SelectField
            label="Example"
            value={wanted ?? (example ? current.name : "")}
            set={(name) => {
              setWanted(name);
              make(post<Structure>("/structures", { kind: "catalogue", name }));
            }}
            options={[...(example ? [] : [{ value: "", text: "–" }]), ...known.map((entry) => ({ value: entry.kind, hint: entry.summary }))]}
          />
          <p class="hint wide">{known.find((entry) => entry.kind === current.name)?.summary}</p>
        </>
      )}
      {origin === "beam" && <BeamForm make={(body) => make(post<Structure>("/structures", body))} />}
      {origin === "file" && (
        <DropZone
          label="Drop a model here, or choose a file"
          hint="JSON body, Nastran .bdf, mesh, npz of matrices"
          take={(files) => make(fromFile(files[0]))}
        />
      )}
      {problem && <ProblemNote problem={problem} />}
    </Group>
  );
}

/** Return a structure from a file: JSON as a body of the API, anything else as an import. */
export async function fromFile(file: File): Promise<Structure> {
  if (!file.name.toLowerCase().endsWith(".json")) {
    const form = new FormData();
    form.append("file", file);
    form.append("name", file.name);
    return upload<Structure>("/structures/import", form);
  }
  return post<Structure>("/structures", parsed(file.name, await file.text()));
}

function parsed(name: string, text: string): unknown {
  try {
    return JSON.parse(text);
  } catch (error) {
    const detail = `${name} is not JSON: ${(error as Error).message}`;
    throw new ProblemError({ title: "The file cannot be read", status: 0, detail, code: "no_json", context: {} });
  }
}

const SUPPORTS: Record<string, { node: "first" | "last"; directions: string[] }[]> = {
  free: [],
  clamped: [{ node: "first", directions: ["X", "Y", "RZ"] }],
  "clamped at both ends": [{ node: "first", directions: ["X", "Y", "RZ"] }, { node: "last", directions: ["X", "Y", "RZ"] }],
  "simply supported": [{ node: "first", directions: ["X", "Y"] }, { node: "last", directions: ["Y"] }],
};

function BeamForm({ make }: { make(body: unknown): void }) {
  const [beam, setBeam] = useState({ length: 1.5, width: 50, height: 10, modulus: 209, density: 7800, loss: 0.005, elements: 20, ends: "free" });
  const set = (change: Partial<typeof beam>) => setBeam({ ...beam, ...change });
  return (
    <>
      <NumberField label="Length" unit="m" value={beam.length} set={(length) => set({ length })} min={0.01} max={100} />
      <NumberField label="Width" unit="mm" value={beam.width} set={(width) => set({ width })} min={0.1} max={1e4} />
      <NumberField label="Height" unit="mm" value={beam.height} set={(height) => set({ height })} min={0.1} max={1e4} />
      <NumberField label="Modulus" unit="GPa" value={beam.modulus} set={(modulus) => set({ modulus })} min={0.001} max={2000} />
      <NumberField label="Density" unit="kg/m³" value={beam.density} set={(density) => set({ density })} min={1} max={30000} />
      <NumberField label="Loss factor" value={beam.loss} set={(loss) => set({ loss })} min={0} max={1} />
      <NumberField label="Elements" value={beam.elements} set={(elements) => set({ elements })} min={2} max={200} whole />
      <SelectField label="Ends" value={beam.ends} set={(ends) => set({ ends })} options={Object.keys(SUPPORTS).map((value) => ({ value }))} />
      <button type="button" class="wide" onClick={() => make(beamBody(beam))}>Build the beam</button>
    </>
  );
}

export interface BeamInput {
  length: number;
  width: number;
  height: number;
  modulus: number;
  density: number;
  loss: number;
  elements: number;
  ends: string;
}

/** Return the body of a beam of rectangular section, from millimetres and gigapascals. */
export function beamBody(beam: BeamInput) {
  const [width, height] = [beam.width / 1000, beam.height / 1000];
  const supports = SUPPORTS[beam.ends].map(({ node, directions }) => ({
    node: node === "first" ? 1 : beam.elements + 1,
    directions,
  }));
  return {
    kind: "beam",
    length: beam.length,
    n_elements: beam.elements,
    section: { area: width * height, second_moment: (width * height ** 3) / 12 },
    material: { modulus: beam.modulus * 1e9, density: beam.density },
    damping: { law: "structural", stiffness_coefficient: beam.loss, mass_coefficient: 0 },
    supports,
  };
}
