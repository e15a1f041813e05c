/** The front panel: hardware on the structure, and the analyser. */

import { catalogue } from "../model";
import { Choice, Group, NumberField, SelectField } from "../parts/fields";
import type { RigDraft } from "../rig";
import { short } from "../format";
import { useLoaded } from "../use";

interface PanelProps {
  rig: RigDraft;
  set(change: Partial<RigDraft>): void;
}

export function HardwarePanel({ rig, set }: PanelProps) {
  const shaker = rig.exciter === "shaker";
  return (
    <Group title="Hardware">
      <Choice
        label="Exciter"
        value={rig.exciter}
        set={(exciter) => set({ exciter, excitation: exciter === "hammer" ? "impact" : "periodic_random", window: exciter === "hammer" ? "force_exponential" : "rectangular" })}
        options={[{ value: "shaker", text: "Shaker" }, { value: "hammer", text: "Hammer" }]}
      />
      {shaker && (
        <>
          <NumberField label="Armature" unit="kg" value={rig.armatureMass} set={(armatureMass) => set({ armatureMass })} min={0} max={5} />
          <NumberField label="Stinger (0: rigid)" unit="N/m" value={rig.stingerStiffness} set={(stingerStiffness) => set({ stingerStiffness })} min={0} max={1e12} />
          <NumberField label="Below force gauge" unit="kg" value={rig.massBelow} set={(massBelow) => set({ massBelow })} min={0} max={0.5} />
        </>
      )}
      <NumberField label="Accelerometer" unit="kg" value={rig.accelerometerMass} set={(accelerometerMass) => set({ accelerometerMass })} min={0} max={0.5} />
    </Group>
  );
}

export function AnalyserPanel({ rig, set }: PanelProps) {
  const lists = useLoaded("catalogue/analyser", () =>
    Promise.all(["windows", "estimators", "excitations"].map(catalogue)),
  );
  const [windows, estimators, excitations] = (lists.value ?? [[], [], []]).map((entries) =>
    entries.map((entry) => ({ value: entry.kind, hint: entry.summary })),
  );
  const spacing = rig.frequencyMax / (rig.nLines - 1);
  return (
    <Group title="Analyser">
      <output class="display">
        <span>Δf {short(spacing, 3)} Hz</span>
        <span>T {short(1 / spacing, 3)} s</span>
      </output>
      <NumberField label="Range" unit="Hz" value={rig.frequencyMax} set={(frequencyMax) => set({ frequencyMax })} min={0.001} max={1e6} />
      <NumberField label="Lines" value={rig.nLines} set={(nLines) => set({ nLines })} min={8} max={1_000_000} whole />
      <NumberField label="Averages" value={rig.averages} set={(averages) => set({ averages })} min={1} max={100_000} whole />
      <NumberField label="Overlap" value={rig.overlap} set={(overlap) => set({ overlap })} min={0} max={0.9} />
      <SelectField label="Window" value={rig.window} set={(window) => set({ window })} options={withCurrent(windows, rig.window)} />
      <SelectField label="Estimator" value={rig.estimator} set={(estimator) => set({ estimator })} options={withCurrent(estimators, rig.estimator).map((option) => ({ ...option, text: option.value.toUpperCase() }))} />
      {rig.exciter === "shaker" && (
        <SelectField label="Excitation" value={rig.excitation} set={(excitation) => set({ excitation })} options={withCurrent(excitations, rig.excitation).filter((option) => option.value !== "impact")} />
      )}
      <NumberField label="Level" unit="N rms" value={rig.level} set={(level) => set({ level })} min={0} />
      <NumberField label="Force noise" value={rig.forceNoise} set={(forceNoise) => set({ forceNoise })} min={0} max={10} />
      <NumberField label="Response noise" value={rig.responseNoise} set={(responseNoise) => set({ responseNoise })} min={0} max={10} />
    </Group>
  );
}

interface Option {
  value: string;
  hint?: string;
}

function withCurrent(options: Option[], current: string): Option[] {
  return options.some((option) => option.value === current) ? options : [{ value: current }, ...options];
}
