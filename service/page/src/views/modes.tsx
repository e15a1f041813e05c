/** Table of modes with their spread, and the shape of the chosen one. */

import { useMemo, useRef } from "preact/hooks";
import { arrays as fetchArrays } from "../api";
import { ShapeDrawing } from "../draw/shape";
import { short, withError } from "../format";
import { type Geometry, type ModalModel, type Mode, type Spread, geometry } from "../model";
import type { Arrays } from "../npz";
import { Actions, csv, svgFile } from "../parts/actions";
import { type Shape, mac, normalised, scaledTo, shapeOf } from "../shape";
import { useLoaded } from "../use";

interface PanelProps {
  model: ModalModel;
  shapes: Arrays;
  structureId?: string;
  chosen: number;
  setChosen(index: number): void;
  python: () => string;
}

export function ModePanel({ model, shapes, structureId, chosen, setChosen, python }: PanelProps) {
  const svg = useRef<SVGSVGElement>(null);
  const loaded = useLoaded(structureId ? `shapes/${structureId}` : null, () => loadStructure(structureId!));
  const measured = useMemo(() => (model.modes[chosen] ? normalised(shapeOf(shapes, chosen)) : null), [shapes, chosen]);
  const partner = useMemo(() => loaded.value && measured && bestPartner(measured, loaded.value.modes), [loaded.value, measured]);
  if (!model.modes.length) return null;
  if (!measured) return null;
  const fits = loaded.value && measured.dofs.some((dof) => loaded.value!.shape.dofs.includes(dof.replace(":-", ":+")));
  const matched = partner && partner.mac > 0.3 ? partner : null;
  const words = `Mode ${chosen + 1}, ${short(model.modes[chosen].frequency)} Hz`;
  return (
    <>
      {fits && (
        <div class="shape-block">
          <ShapeDrawing svgRef={svg} geometry={loaded.value!.shape} measured={measured} model={matched && scaledTo(measured, matched.shape)} label={`${words}, measured shape${matched ? " and the model's" : ""}`} />
          <p class="shape-words">
            <b>{words}</b>
            <span class="inline"><span class="swatch sensor" /> measured</span>
            {matched && <span class="inline"><span class="swatch model" /> model mode {matched.index + 1}, {short(matched.frequency)} Hz, MAC {matched.mac.toFixed(3)}</span>}
          </p>
        </div>
      )}
      <ModeTable modes={model.modes} chosen={chosen} choose={setChosen} />
      {model.notes.map((note) => <p class="notice">{note}</p>)}
      <Actions
        python={python}
        downloads={[
          { text: "CSV", name: "modes.csv", from: () => csv(tableOf(model.modes)) },
          { text: "UFF", name: `${model.id}.uff`, from: `v1/modal-models/${model.id}/modes.uff` },
          ...(fits ? [{ text: "SVG", name: `mode-${chosen + 1}.svg`, from: () => svgFile(svg.current!) }] : []),
        ]}
      />
    </>
  );
}

function ModeTable({ modes, chosen, choose }: { modes: Mode[]; chosen: number; choose(index: number): void }) {
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Table of modes">
      <table>
        <caption>Standard errors in brackets; the spread is over the FRFs.</caption>
        <thead>
          <tr>
            <th scope="col">Mode</th>
            <th scope="col">Frequency, Hz</th>
            <th scope="col">Spread, Hz</th>
            <th scope="col">Loss factor</th>
            <th scope="col">Spread</th>
            <th scope="col">FRFs</th>
            <th scope="col" class="text">Flags</th>
          </tr>
        </thead>
        <tbody>
          {modes.map((mode, i) => (
            <tr class={i === chosen ? "pick chosen" : "pick"} onClick={() => choose(i)}>
              <td><button type="button" class="pick-button" aria-pressed={i === chosen} aria-label={`Show mode ${i + 1}`} onClick={() => choose(i)}>{i + 1}</button></td>
              <td>{withError(mode.frequency, mode.standard_errors.frequency)}</td>
              <td><SpreadOf spread={mode.frequency_spread} /></td>
              <td>{withError(mode.loss_factor, mode.standard_errors.loss_factor)}</td>
              <td><SpreadOf spread={mode.loss_factor_spread} /></td>
              <td>{mode.frequency_spread?.n ?? "–"}</td>
              <td class="text">{mode.flags.join("; ") || <span class="hint">none</span>}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function SpreadOf({ spread }: { spread: Spread | null }) {
  if (!spread) return <>–</>;
  return <span title={`${short(spread.min, 6)} to ${short(spread.max, 6)}`}>± {short(spread.sd, 2)}</span>;
}

function tableOf(modes: Mode[]): Record<string, (number | string | null)[]> {
  return {
    mode: modes.map((_, i) => i + 1),
    "frequency, Hz": modes.map((mode) => mode.frequency),
    "standard error, Hz": modes.map((mode) => mode.standard_errors.frequency ?? null),
    "loss factor": modes.map((mode) => mode.loss_factor),
    "standard error": modes.map((mode) => mode.standard_errors.loss_factor ?? null),
    ...Object.assign({}, ...(["frequency_spread", "loss_factor_spread"] as const).map((name) => spreadColumns(modes, name))),
    flags: modes.map((mode) => mode.flags.join("; ")),
  };
}

function spreadColumns(modes: Mode[], name: "frequency_spread" | "loss_factor_spread") {
  const of = (key: keyof Spread) => modes.map((mode) => mode[name]?.[key] ?? null);
  return Object.fromEntries((["min", "max", "mean", "sd", "n"] as const).map((key) => [`${name} ${key}`, of(key)]));
}

interface ModelMode {
  frequency: number;
  shape: Shape;
}

export async function loadStructure(id: string): Promise<{ shape: Geometry; modes: ModelMode[] }> {
  const [shape, found] = await Promise.all([geometry(id), fetchArrays(`/structures/${id}/modes/arrays?count=20`)]);
  const frequencies = found.frequencies.values as Float64Array;
  return { shape, modes: Array.from(frequencies, (frequency, i) => ({ frequency, shape: shapeOf(found, i) })) };
}

function bestPartner(measured: Shape, modes: ModelMode[]) {
  const ranked = modes.map((mode, index) => ({ ...mode, index, mac: mac(measured, mode.shape) }));
  return ranked.reduce((best, mode) => (mode.mac > best.mac ? mode : best), { ...ranked[0], mac: 0 });
}
