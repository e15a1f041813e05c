/** Values at the cursor of a stack of plots. */

import { short } from "../format";

interface ReadoutProps {
  freq: Float64Array;
  index: number | null;
  values: { label: string; tone: string; text: string }[];
}

export function Readout({ freq, index, values }: ReadoutProps) {
  const shown = values.slice(0, 12);
  return (
    <div class="readout" aria-live="polite">
      <span class="readout-freq">{index === null ? "Cursor" : `${short(freq[index], 6)} Hz`}</span>
      {shown.map(({ label, tone, text }) => (
        <span class="readout-value">
          <i class="swatch" style={{ background: tone.startsWith("--") ? `var(${tone})` : tone }} />
          {label} <b>{index === null ? "" : text}</b>
        </span>
      ))}
      {values.length > shown.length && <span class="hint">and {values.length - shown.length} more</span>}
    </div>
  );
}
