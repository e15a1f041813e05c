/** Coefficients of one part by iteration: those of suspected members in colour. */

import { Figure, type Series } from "../plot/figure";

export interface Iteration {
  stage: string;
  macros: { part: string; members: number[] }[];
  coefficients: (number | null)[];
}

export function Iterations({ history, part, suspected }: { history: Iteration[]; part: string; suspected: number[] }) {
  const series = seriesOf(history, part, suspected);
  if (!series.length) return null;
  return (
    <div class="figures">
      <Figure title={`${part} coefficients by iteration`} x="iteration" y="coefficient" series={series} />
    </div>
  );
}

/** Return a line for each coefficient, from 1, which changes nothing, on; suspected ones last, to lie on top. */
export function seriesOf(history: Iteration[], part: string, suspected: number[]): Series[] {
  const paths = new Map<string, { members: number[]; x: number[]; y: number[] }>();
  history.forEach(({ macros, coefficients }, i) =>
    macros.forEach(({ part: of, members }, k) => {
      const value = coefficients[k];
      if (of !== part || value === null) return;
      const path = paths.get(members.join()) ?? { members, x: [i], y: [1] };
      path.x.push(i + 1);
      path.y.push(value);
      paths.set(members.join(), path);
    }),
  );
  const isSuspected = (members: number[]) => members.some((member) => suspected.includes(member));
  const drawn = [...paths.values()].sort((a, b) => Number(isSuspected(a.members)) - Number(isSuspected(b.members)));
  return drawn.map(({ members, x, y }, i) => {
    const named = isSuspected(members);
    const label = named ? `${members.length > 1 ? "members" : "member"} ${members.join(", ")}` : i === 0 ? "others" : "";
    return { label, x, y, mark: "line", tone: named ? "warm" : "faint" };
  });
}
