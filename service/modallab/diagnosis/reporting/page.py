"""HTML elements of a report: page with style sheet, paragraphs, tables."""

from collections.abc import Sequence
from html import escape

STYLE = """
:root { color-scheme: light; --ink: #1c2230; --soft: #596275; --paper: #fff; --rule: #d8dce4;
  --before: #c2410c; --after: #1d63c4; --noise: #aab2bf; }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; color: var(--ink);
  background: var(--paper); max-width: 1040px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .5rem; text-wrap: balance; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .4rem; }
p { max-width: 76ch; margin: .5rem 0; }
.soft, figcaption, caption { color: var(--soft); font-size: .88rem; }
.lead { font-size: 1.05rem; }
.call { white-space: pre-wrap; overflow-wrap: anywhere; font: .85rem/1.45 ui-monospace, "DejaVu Sans Mono",
  monospace; background: #f4f5f8; border: 1px solid var(--rule); border-radius: 4px; padding: .6rem .8rem; }
.next { border-left: 4px solid var(--after); padding: .1rem 1rem; background: #f3f6fb; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; min-width: min(100%, 34rem); margin: .5rem 0; }
caption { text-align: left; }
th, td { text-align: right; padding: .28rem 1.1rem .28rem 0; border-bottom: 1px solid var(--rule);
  font-variant-numeric: tabular-nums; vertical-align: top; }
th { font-weight: 600; color: var(--soft); font-size: .88rem; }
.word { text-align: left; }
tr.named td { font-weight: 600; }
ul { margin: .4rem 0; padding-left: 1.2rem; max-width: 76ch; }
.two { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 340px), 1fr));
  gap: .5rem 2rem; }
figure { margin: .6rem 0 1rem; min-width: 0; }
figure.middle { max-width: 520px; }
svg { width: 100%; height: auto; display: block; overflow: visible; }
svg text { fill: var(--soft); font-size: 12px; }
svg .tick, svg .label { text-anchor: middle; }
svg .tick { paint-order: stroke; stroke: var(--paper); stroke-width: 3px; }
svg .side { text-anchor: end; }
svg .name { fill: var(--ink); font-size: 12.5px; }
svg path { fill: none; stroke-linejoin: round; }
svg .grid { stroke: var(--rule); stroke-width: .7; }
svg .measured { stroke: var(--ink); stroke-width: 1.1; }
svg .before { stroke: var(--before); stroke-width: 1.5; }
svg .after { stroke: var(--after); stroke-width: 1.7; stroke-dasharray: 5 3; }
svg .left { stroke: var(--after); stroke-width: 1; }
svg .one { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 2 3; }
svg .bar { stroke: var(--ink); stroke-width: 1; }
svg .haze { stroke: var(--noise); stroke-width: 1; }
svg .dot { fill: var(--ink); }
svg .noise { fill: var(--noise); opacity: .5; }
svg .fitted { fill: var(--after); }
svg .held { fill: var(--noise); }
svg .member { stroke: var(--ink); stroke-width: 3; }
svg .rim { stroke: var(--soft); stroke-width: 1; }
svg .marked { stroke: var(--before); stroke-width: 7; stroke-linecap: round; opacity: .75; }
svg .node { stroke: var(--ink); stroke-width: 1; }
svg .ring { fill: none; stroke: var(--before); stroke-width: 3; }
svg .force { stroke: var(--ink); stroke-width: 1.8; }
.l0 { fill: #eef0f4; background: #eef0f4; } .l1 { fill: #fee3a8; background: #fee3a8; }
.l2 { fill: #fdb158; background: #fdb158; } .l3 { fill: #e4572e; background: #e4572e; }
.l4 { fill: #7a1022; background: #7a1022; }
@media (max-width: 620px) { body { margin: 1rem auto; } h1 { font-size: 1.35rem; }
  .cards thead { display: none; } .cards tr { display: block; border-bottom: 1px solid var(--rule); }
  .cards td { display: grid; grid-template-columns: 7.5rem 1fr; text-align: left;
    border: 0; padding: .1rem 0; }
  .cards td::before { content: attr(data-label); color: var(--soft); font-size: .88rem; } }
.entry { white-space: nowrap; margin-right: .9em; }
.key { display: inline-block; width: 1.6em; margin-right: .4em; vertical-align: middle;
  border-top: 2px solid var(--ink); print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.key.before { border-color: var(--before); } .key.after { border-top: 2px dashed var(--after); }
.key.noise, .key.fitted, .key.held, .key[class*=" l"] { height: .75em; border: 0; }
.key.noise, .key.held { background: var(--noise); } .key.fitted { background: var(--after); }
@media print { body { max-width: none; margin: 0; font-size: 10.5pt; } h2 { break-after: avoid; }
  figure, table, .next { break-inside: avoid; } .two { grid-template-columns: 1fr 1fr; gap: .3rem 1rem; }
  h2 + p, h2 + ul { break-after: avoid; } @page { margin: 16mm; } }
"""

Row = Sequence[str]


def page(title: str, parts: Sequence[str]) -> str:
    """Return a self-contained page, which refers to no other file."""
    head = (
        f'<meta charset="utf-8"/><meta name="viewport" content="width=device-width, initial-scale=1"/>'
        f"<title>{escape(title)}</title><style>{STYLE}</style>"
    )
    body = "\n".join(part for part in parts if part)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body><main>\n{body}\n</main></body></html>\n'
    )


def paragraph(words: str, style: str = "") -> str:
    """Return a paragraph with escaped text."""
    return f'<p class="{style}">{escape(words)}</p>' if style else f"<p>{escape(words)}</p>"


def table(
    head: Row,
    rows: Sequence[Row],
    *,
    n_text_columns: int = 1,
    highlighted: int | None = None,
    style: str = "",
) -> str:
    """Return a table with escaped cells.

    Parameters
    ----------
    n_text_columns
        Columns from the left that hold text; the others hold numbers, aligned to the right.
    highlighted
        Index of a row to highlight.
    style
        `cards`: a narrow screen shows each row as a list.
    """
    marks = [' class="word"' if i < n_text_columns else "" for i in range(len(head))]
    top = "".join(
        f'<th scope="col"{mark}>{escape(cell)}</th>' for cell, mark in zip(head, marks, strict=True)
    )
    lines = []
    for i, row in enumerate(rows):
        cells = "".join(
            f'<td{mark} data-label="{escape(name)}">{escape(cell)}</td>'
            for cell, name, mark in zip(row, head, marks, strict=True)
        )
        lines.append(f'<tr class="named">{cells}</tr>' if i == highlighted else f"<tr>{cells}</tr>")
    return (
        f'<div class="wide"><table class="{style}"><thead><tr>{top}</tr></thead>'
        f"<tbody>{''.join(lines)}</tbody></table></div>"
    )
