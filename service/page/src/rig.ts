/** The rig that is being set up, and the request that declares it. */

export interface RigDraft {
  drive: string;
  responses: string[];
  exciter: "shaker" | "hammer";
  armatureMass: number;
  stingerStiffness: number;
  massBelow: number;
  accelerometerMass: number;
  frequencyMax: number;
  nLines: number;
  window: string;
  averages: number;
  overlap: number;
  estimator: string;
  excitation: string;
  level: number;
  forceNoise: number;
  responseNoise: number;
}

export const USUAL: Omit<RigDraft, "drive" | "responses" | "frequencyMax"> = {
  exciter: "shaker",
  armatureMass: 0.02,
  stingerStiffness: 0,
  massBelow: 0.01,
  accelerometerMass: 0.01,
  nLines: 801,
  window: "rectangular",
  averages: 30,
  overlap: 0,
  estimator: "h1",
  excitation: "periodic_random",
  level: 1,
  forceNoise: 1e-4,
  responseNoise: 1e-4,
};

/** Return the body of `POST /v1/rigs`. */
export function bodyOf(rig: RigDraft): Record<string, unknown> {
  const shaker = rig.exciter === "shaker";
  return {
    drive: rig.drive,
    responses: rig.responses,
    exciter: shaker ? { kind: "shaker", armature_mass: rig.armatureMass } : { kind: "hammer" },
    ...(shaker && rig.stingerStiffness > 0 && { stinger: { axial_stiffness: rig.stingerStiffness } }),
    ...(shaker && { force_transducer: { mass_below: rig.massBelow } }),
    accelerometers: { mass: rig.accelerometerMass },
    analyser: {
      frequency_max: rig.frequencyMax,
      n_lines: rig.nLines,
      window: rig.window,
      averages: rig.averages,
      overlap: rig.overlap,
      estimator: rig.estimator,
      excitation: { kind: shaker ? rig.excitation : "impact", level: rig.level },
    },
    noise: { force: rig.forceNoise, response: rig.responseNoise },
  };
}

/** Return what differs from the usual rig, as text for an address. */
export function packed(rig: RigDraft): string {
  const entries = Object.entries(rig).filter(([name, value]) => (USUAL as Record<string, unknown>)[name] !== value);
  return JSON.stringify(Object.fromEntries(entries));
}

/** Return the rig of an address; what cannot be read is left as it usually is. */
export function unpacked(text: string | undefined, usual: RigDraft): RigDraft {
  if (!text) return usual;
  try {
    const given = JSON.parse(text) as Partial<RigDraft>;
    const known = Object.entries(given).filter(
      ([name, value]) => name in usual && typeof value === typeof usual[name as keyof RigDraft],
    );
    return { ...usual, ...Object.fromEntries(known) };
  } catch {
    return usual;
  }
}

/** Return a usual rig on a structure: driven at its first DoF, with accelerometers spread over it. */
export function usualRig(dofs: string[], frequencies: number[]): RigDraft {
  const direction = mainDirection(dofs);
  const along = dofs.filter((dof) => dof.endsWith(`:+${direction}`));
  const spacing = Math.max(1, Math.ceil(along.length / (along.length > 60 ? 24 : 11)));
  const responses = along.filter((_, i) => i % spacing === 0);
  const tip = along[0].startsWith("1:") ? along[0] : along[along.length - 1];
  return { ...USUAL, drive: tip, responses, frequencyMax: niceAbove(frequencies.slice(0, 8).at(-1) ?? 800) };
}

/** Return the direction that bending moves: across a plate, else across a beam. */
export function mainDirection(dofs: string[]): string {
  const count = (d: string) => dofs.filter((dof) => dof.endsWith(`:+${d}`)).length;
  return ["Z", "Y", "X"].reduce((best, d) => (count(d) > count(best) ? d : best));
}

export function directionsAt(dofs: string[]): string[] {
  return ["X", "Y", "Z"].filter((d) => dofs.some((dof) => dof.endsWith(`:+${d}`)));
}

function niceAbove(frequency: number): number {
  const power = 10 ** Math.floor(Math.log10(frequency));
  return [1, 1.6, 2, 2.5, 3.2, 4, 5, 6.4, 8, 10, 16].map((step) => step * power).find((f) => f > 1.05 * frequency)!;
}
