/** Effects that are in the structure or the rig, and in no log book: for a diagnosis to find. */

import { useState } from "preact/hooks";
import { words } from "../format";
import { HIDDEN_ROWS, type HiddenRow, hiddenEffects, setHiddenEffects, usualPlace } from "../hidden";
import { type CatalogueEntry, catalogue } from "../model";
import { NumberField, SelectField } from "../parts/fields";
import type { HiddenEffect } from "../python";
import type { RigDraft } from "../rig";
import { useLoaded } from "../use";

interface HiddenProps {
  rig: RigDraft;
  dofs: string[];
  members: number[];
}

export function HiddenPanel({ rig, dofs, members }: HiddenProps) {
  const [effects, setEffects] = useState(hiddenEffects);
  const entries = useLoaded("catalogue/effects", () => catalogue("effects"));
  const about = new Map((entries.value ?? []).map((entry) => [entry.kind, entry]));
  const change = (next: HiddenEffect[]) => {
    setHiddenEffects(next);
    setEffects(next);
  };
  const flip = (row: HiddenRow) => {
    const on = effects.some((effect) => effect.kind === row.kind);
    const at = usualPlace(row, dofs, members, rig.responses, rig.drive);
    change(on ? effects.filter((effect) => effect.kind !== row.kind) : [...effects, { kind: row.kind, at, parameters: { ...row.parameters } }]);
  };
  const replace = (effect: HiddenEffect) => change(effects.map((other) => (other.kind === effect.kind ? effect : other)));
  const groups = [...new Set(HIDDEN_ROWS.map((row) => row.group))];
  return (
    <details class="hidden-effects" open={matchMedia("(min-width: 641px)").matches}>
      <summary>
        Hidden effects <span class="count">{effects.length ? `${effects.length} on` : "none"}</span>
      </summary>
      <p class="hint">They act in the test and stand in no log book. A diagnosis has to find them. A shared address does not tell them.</p>
      <div class="switch-groups">
        {groups.map((group) => (
          <fieldset class="switches">
            <legend>{group}</legend>
            {HIDDEN_ROWS.filter((row) => row.group === group).map((row) => (
              <Switch row={row} entry={about.get(row.kind)} effect={effects.find((effect) => effect.kind === row.kind)} flip={() => flip(row)} replace={replace} places={{ dofs, members, responses: rig.responses }} />
            ))}
          </fieldset>
        ))}
      </div>
    </details>
  );
}

interface SwitchProps {
  row: HiddenRow;
  entry?: CatalogueEntry;
  effect?: HiddenEffect;
  flip(): void;
  replace(effect: HiddenEffect): void;
  places: { dofs: string[]; members: number[]; responses: string[] };
}

function Switch({ row, entry, effect, flip, replace, places }: SwitchProps) {
  return (
    <div class="switch-row">
      <label class="switch" title={entry?.summary}>
        <input type="checkbox" role="switch" checked={effect !== undefined} onChange={flip} />
        <span>{words(row.kind)}</span>
      </label>
      {effect && (
        <div class="switch-fields">
          <PlaceField row={row} effect={effect} replace={replace} places={places} />
          {Object.entries(effect.parameters).map(([name, value]) => (
            <NumberField
              label={words(name)}
              unit={entry?.parameters[name]?.unit.replace(/^1$/, "")}
              value={value}
              min={entry?.parameters[name]?.lower}
              max={entry?.parameters[name]?.upper}
              set={(next) => replace({ ...effect, parameters: { ...effect.parameters, [name]: next } })}
            />
          ))}
        </div>
      )}
    </div>
  );
}

function PlaceField({ row, effect, replace, places }: Omit<SwitchProps, "entry" | "flip"> & { effect: HiddenEffect }) {
  if (row.place === "everywhere" || row.place === "drive") return null;
  const member = row.place === "members";
  const options = member ? places.members.map(String) : row.place === "channel" ? places.responses : places.dofs;
  const at = effect.at as string & { members?: number[]; channels?: string[] };
  const value = member ? String(at.members?.[0]) : row.place === "channel" ? at.channels?.[0] : at;
  const set = (next: string) =>
    replace({ ...effect, at: member ? { members: [Number(next)] } : row.place === "channel" ? { channels: [next] } : next });
  const label = member ? "member" : row.place === "channel" ? "channel" : "at";
  return <SelectField label={label} value={value ?? ""} set={set} options={options.map((option) => ({ value: option, text: option }))} />;
}
