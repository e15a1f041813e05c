/** A place to drop a file, or to choose one. */

import { useId, useState } from "preact/hooks";

interface DropProps {
  label: string;
  hint: string;
  accept?: string;
  take(files: File[]): void;
  busy?: boolean;
}

export function DropZone({ label, hint, accept, take, busy }: DropProps) {
  const id = useId();
  const [over, setOver] = useState(false);
  const drop = (event: DragEvent) => {
    event.preventDefault();
    setOver(false);
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length) take(files);
  };
  return (
    <div
      class={`drop${over ? " over" : ""}`}
      onDragOver={(event) => { event.preventDefault(); setOver(true); }}
      onDragLeave={() => setOver(false)}
      onDrop={drop}
    >
      <label for={id}>{label}</label>
      <span class="hint">{busy ? "Reading …" : hint}</span>
      <input
        id={id}
        type="file"
        multiple
        accept={accept}
        disabled={busy}
        onChange={(event) => {
          const files = [...(event.currentTarget.files ?? [])];
          if (files.length) take(files);
          event.currentTarget.value = "";
        }}
      />
    </div>
  );
}
