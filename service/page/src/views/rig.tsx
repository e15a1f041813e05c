/** View 1: the structure, the hardware on it, the analyser, and what no log book tells. */

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { type Problem, post } from "../api";
import { RigDrawing } from "../draw/structure";
import { splitDof } from "../draw/projection";
import { short } from "../format";
import { type Structure, catalogue, geometry, structure, structureModes } from "../model";
import { Actions, svgFile } from "../parts/actions";
import { Choice } from "../parts/fields";
import { Empty, Loading, ProblemNote } from "../parts/notes";
import { program, rigLines, structureLine } from "../python";
import { type RigDraft, directionsAt, mainDirection, packed, unpacked, usualRig } from "../rig";
import { type State, address, go } from "../state";
import { asProblem, useActions, useKept, useLoaded } from "../use";
import { AnalyserPanel, HardwarePanel } from "./analyser";
import { HiddenPanel } from "./hidden-panel";
import { StructurePanel } from "./structure-panel";

const FIRST = "chapter-5-beam";

export function RigView({ state }: { state: State }) {
  const [problem, setProblem] = useState<Problem | null>(null);
  useEffect(() => {
    if (state.s) return;
    // Something to look at, before anything is read.
    post<Structure>("/structures", { kind: "catalogue", name: FIRST }).then(
      (made) => go({ s: made.id }, true),
      (error) => setProblem(asProblem(error)),
    );
  }, [state.s]);
  if (problem) return <ProblemNote problem={problem} again={() => location.reload()} />;
  if (!state.s) return <Loading what="the laboratory" />;
  return <RigOn id={state.s} state={state} />;
}

function RigOn({ id, state }: { id: string; state: State }) {
  const known = useLoaded("catalogue/structures", () => catalogue("structures"));
  // The former structure stays until the next one is there, and with it the focus on what has chosen that.
  const found = useKept(useLoaded(`rig/${id}`, () => Promise.all([structure(id), geometry(id), structureModes(id)])));
  const svg = useRef<SVGSVGElement>(null);
  const usual = useMemo(
    () => found.value && usualRig(found.value[1].dofs, found.value[2].frequencies),
    [found.value],
  );
  if (found.problem) return <ProblemNote problem={found.problem} again={() => go({ s: undefined, rig: undefined })} />;
  if (!found.value || !usual) return <Loading what="the structure" />;
  const [about, shape, modes] = found.value;
  const rig = unpacked(state.rig, usual);
  const set = (change: Partial<RigDraft>) => go({ rig: packed({ ...rig, ...change }) }, true);
  const direction = splitDof(rig.responses[0] ?? rig.drive).direction;
  const python = () => program([structureLine(about.name, about.id, known.value), ...rigLines(rig)]);
  return (
    <div class="bench">
      <section class="stage" aria-labelledby="rig-title">
        <div class="stage-head">
          <h1 id="rig-title">{about.name || "Structure"}</h1>
          <p class="facts">
            {about.n_nodes} nodes, {about.members} members, {about.n_dofs} degrees of freedom. Elastic modes from {short(modes.frequencies[0])} Hz
            {modes.loss_factors[0] > 0 ? `, loss factor ${short(modes.loss_factors[0], 2)}` : ", undamped"}.
          </p>
        </div>
        <div class="drawing">
          <RigDrawing
            key={about.id}
            svgRef={svg}
            geometry={shape}
            drive={rig.drive}
            responses={rig.responses}
            direction={direction}
            exciter={rig.exciter}
            stinger={rig.stingerStiffness > 0}
            toggle={(node) => set({ responses: toggled(rig.responses, `${node}:+${direction}`, shape.dofs) })}
            move={(node) => set(moved(rig, node, shape.dofs))}
          />
        </div>
        <div class="under-drawing">
          <DriveAndDirection rig={rig} dofs={shape.dofs} direction={direction} set={set} />
          <Actions downloads={[{ text: "SVG", name: "rig.svg", from: () => svgFile(svg.current!) }]} python={python} />
        </div>
        {modes.loss_factors[0] === 0 && <Undamped id={about.id} members={shape.members.map((member) => member.number)} />}
        {rig.responses.length === 0 && <Empty title="No accelerometer"><p>Click a node to set one.</p></Empty>}
        <HiddenPanel key={`hidden/${about.id}`} rig={rig} dofs={shape.dofs.filter((dof) => dof.endsWith(`:+${mainDirection(shape.dofs)}`))} members={shape.members.map((member) => member.number)} />
      </section>
      <aside class="panel" aria-label="Settings">
        <StructurePanel current={about} known={known.value ?? []} />
        <HardwarePanel rig={rig} set={set} />
        <AnalyserPanel rig={rig} set={set} />
        <a class="next" href={address({ ...state, view: "measure", rig: packed(rig) })}>Measure</a>
      </aside>
    </div>
  );
}

function DriveAndDirection({ rig, dofs, direction, set }: { rig: RigDraft; dofs: string[]; direction: string; set(change: Partial<RigDraft>): void }) {
  const all = dofs.filter((dof) => dof.endsWith(`:+${direction}`));
  const others = directionsAt(dofs);
  return (
    <div class="legend-row">
      <label class="inline">
        <span class="swatch drive" /> Drive
        <select value={rig.drive} onChange={(event) => set({ drive: event.currentTarget.value })}>
          {dofs.filter((dof) => !/:\+R/.test(dof)).map((dof) => <option>{dof}</option>)}
        </select>
      </label>
      <span class="inline"><span class="swatch sensor" /> {rig.responses.length} accelerometers</span>
      <button type="button" class="quiet" onClick={() => set({ responses: all })}>All nodes</button>
      {others.length > 1 && (
        <Choice
          label="Direction"
          value={direction}
          set={(next) => set({ responses: turned(rig.responses, next, dofs), drive: turned([rig.drive], next, dofs)[0] ?? rig.drive })}
          options={others.map((d) => ({ value: d, text: d }))}
        />
      )}
    </div>
  );
}

function Undamped({ id, members }: { id: string; members: number[] }) {
  const { run, busy, problem } = useActions();
  const changes = [{ members, property: "loss_factor", value: 0.005 }];
  const give = async () => go({ s: (await post<Structure>(`/structures/${id}/changes`, { changes })).id });
  return (
    <div class="notice">
      <p>This model has no damping: its resonances would be infinite.</p>
      <button type="button" disabled={busy} onClick={() => run(give)}>Give every member a loss factor of 0.005</button>
      {problem && <ProblemNote problem={problem} />}
    </div>
  );
}

function toggled(responses: string[], dof: string, dofs: string[]): string[] {
  if (responses.includes(dof)) return responses.filter((other) => other !== dof);
  const all = new Set([...responses, dof]);
  return dofs.filter((free) => all.has(free));
}

function moved(rig: RigDraft, node: string, dofs: string[]): Partial<RigDraft> {
  const wanted = `${node}:+${splitDof(rig.drive).direction}`;
  return dofs.includes(wanted) ? { drive: wanted } : {};
}

function turned(responses: string[], direction: string, dofs: string[]): string[] {
  return responses.map((dof) => `${splitDof(dof).node}:+${direction}`).filter((dof) => dofs.includes(dof));
}
