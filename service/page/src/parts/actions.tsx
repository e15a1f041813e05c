/** Take it with you: downloads, and the same work as Python. */

import { useState } from "preact/hooks";

export interface Download {
  text: string;
  /** Address of a file that the service makes, or what makes one here. */
  from: string | (() => Promise<Blob> | Blob);
  name: string;
}

export function Actions({ downloads, python }: { downloads?: Download[]; python?: () => string }) {
  return (
    <div class="actions">
      {downloads?.map((download) => <Save {...download} />)}
      {python && <CopyPython code={python} />}
    </div>
  );
}

function Save({ text, from, name }: Download) {
  if (typeof from === "string") return <a class="action" href={from} download={name}>{text}</a>;
  return (
    <button type="button" class="action" onClick={async () => save(await from(), name)}>{text}</button>
  );
}

export function save(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function CopyPython({ code }: { code: () => string }) {
  const [copied, setCopied] = useState<"" | "copied" | "shown">("");
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(code());
      setCopied("copied");
      setTimeout(() => setCopied(""), 2500);
    } catch {
      setCopied("shown"); // the browser allows no clipboard: over http from another host
    }
  };
  return (
    <>
      <button type="button" class="action" onClick={copy} data-python={code()}>
        {copied === "copied" ? "Copied" : "Copy as Python"}
      </button>
      <span class="visually-hidden" role="status">{copied === "copied" ? "The code is on the clipboard." : ""}</span>
      {copied === "shown" && <textarea class="code" readOnly rows={8} aria-label="Python code" value={code()} />}
    </>
  );
}

export function csv(columns: Record<string, ArrayLike<number | string | null>>): Blob {
  const names = Object.keys(columns);
  const length = Math.max(...names.map((name) => columns[name].length));
  const cell = (value: number | string | null | undefined) => {
    const text = value === null || value === undefined ? "" : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const rows = Array.from({ length }, (_, i) => names.map((name) => cell(columns[name][i])).join(","));
  return new Blob([[names.map(cell).join(","), ...rows, ""].join("\n")], { type: "text/csv" });
}

const DRAWN = ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin", "opacity", "font-size", "font-weight", "font-family", "text-anchor", "paint-order"];

/** Return a drawing as a file that needs no style sheet. */
export function svgFile(svg: SVGSVGElement): Blob {
  const copy = svg.cloneNode(true) as SVGSVGElement;
  const sources = svg.querySelectorAll("*");
  copy.querySelectorAll("*").forEach((element, i) => {
    const style = getComputedStyle(sources[i]);
    for (const name of DRAWN) element.setAttribute(name, style.getPropertyValue(name));
    element.removeAttribute("class");
  });
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  const { width, height } = svg.getBoundingClientRect();
  copy.setAttribute("width", String(Math.round(width)));
  copy.setAttribute("height", String(Math.round(height)));
  return new Blob([new XMLSerializer().serializeToString(copy)], { type: "image/svg+xml" });
}
