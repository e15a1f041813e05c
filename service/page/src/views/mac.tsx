/** Modal assurance criterion as a matrix, and the pairs that follow from it. */

import { useRef } from "preact/hooks";
import { minus, short } from "../format";
import { Actions, csv, svgFile } from "../parts/actions";

export interface Correlation {
  mac: number[][];
  pairs: [number, number][];
  frequency_differences: number[];
  comac: number[];
  dofs: string[];
}

export function MacMatrix({ mac }: { mac: number[][] }) {
  const svg = useRef<SVGSVGElement>(null);
  const [rows, columns] = [mac.length, mac[0]?.length ?? 0];
  const cell = Math.min(44, 420 / Math.max(rows, columns, 1));
  const [left, top] = [44, 34];
  const numbers = cell > 30;
  return (
    <figure class="mac">
      <figcaption class="hint">MAC: measured modes down, the model's across</figcaption>
      <svg ref={svg} viewBox={`0 0 ${left + columns * cell + 4} ${top + rows * cell + 4}`} role="img" aria-label={`MAC of ${rows} measured and ${columns} modes of the model`}>
        {Array.from({ length: columns }, (_, j) => <text x={left + (j + 0.5) * cell} y={top - 10}>{j + 1}</text>)}
        {mac.map((row, i) => (
          <g>
            <text x={left - 14} y={top + (i + 0.5) * cell + 5}>{i + 1}</text>
            {row.map((value, j) => (
              <g>
                <title>{`measured ${i + 1}, model ${j + 1}: ${value.toFixed(3)}`}</title>
                <rect class="mac-ground" x={left + j * cell + 1} y={top + i * cell + 1} width={cell - 2} height={cell - 2} />
                <rect class="mac-cell" x={left + j * cell + 1} y={top + i * cell + 1} width={cell - 2} height={cell - 2} opacity={Math.max(0, value)} />
                {numbers && value > 0.095 && <text class={value > 0.55 ? "mac-number dark" : "mac-number"} x={left + (j + 0.5) * cell} y={top + (i + 0.5) * cell + 4}>{value > 0.995 ? "1" : value.toFixed(2).slice(1)}</text>}
              </g>
            ))}
          </g>
        ))}
      </svg>
      <Actions downloads={[{ text: "SVG", name: "mac.svg", from: () => svgFile(svg.current!) }, { text: "CSV", name: "mac.csv", from: () => csv(Object.fromEntries(Array.from({ length: columns }, (_, j) => [`model ${j + 1}`, mac.map((row) => row[j])]))) }]} />
    </figure>
  );
}

export function PairTable({ correlation, measured, python }: { correlation: Correlation; measured: number[]; python?: () => string }) {
  const rows = correlation.pairs.map(([i, j], k) => {
    const frequency = measured[i - 1];
    const difference = correlation.frequency_differences[k];
    return { i, j, frequency, model: frequency - difference, relative: (100 * difference) / (frequency - difference), mac: correlation.mac[i - 1][j - 1] };
  });
  return (
    <div>
      <div class="scroll" tabIndex={0} role="region" aria-label="Table of paired modes">
        <table>
          <caption>Paired modes</caption>
          <thead>
            <tr>
              <th scope="col">Measured</th>
              <th scope="col">Hz</th>
              <th scope="col">Model</th>
              <th scope="col">Hz</th>
              <th scope="col">Difference</th>
              <th scope="col">MAC</th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr>
                <td>{row.i}</td>
                <td>{short(row.frequency, 5)}</td>
                <td>{row.j}</td>
                <td>{short(row.model, 5)}</td>
                <td>{minus(row.relative.toFixed(2))} %</td>
                <td>{row.mac.toFixed(3)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <Actions python={python} downloads={[{ text: "CSV", name: "pairs.csv", from: () => csv({ measured: rows.map((r) => r.i), "measured, Hz": rows.map((r) => r.frequency), model: rows.map((r) => r.j), "model, Hz": rows.map((r) => r.model), MAC: rows.map((r) => r.mac) }) }]} />
    </div>
  );
}
