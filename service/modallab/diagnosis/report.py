"""A diagnosis as one page: words, tables, curves; nothing is fetched and nothing is run."""

from collections.abc import Sequence
from html import escape

import numpy as np

from modallab.diagnosis import svg, wording
from modallab.diagnosis.figures import all_curves, keys
from modallab.diagnosis.result import Diagnosis, Rival
from modallab.rig.effect import EFFECTS

STYLE = """
:root { color-scheme: light dark; --ink: #1c2230; --soft: #667085; --paper: #fff; --rule: #d8dce4;
  --before: #c2410c; --after: #1d63c4; --noise: #9aa3b2; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ef; --soft: #98a2b3; --paper: #14171d;
  --rule: #333a47; --before: #fb923c; --after: #6aa9ff; --noise: #6b7484; } }
@media print { :root { --ink: #000; --soft: #444; --paper: #fff; --rule: #ccc; --before: #c2410c;
  --after: #1d63c4; } figure, table, h2 { break-inside: avoid; } h2 { break-after: avoid; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 780px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.55rem; line-height: 1.25; margin: 0 0 .5rem; }
h2 { font-size: 1.1rem; margin: 2rem 0 .4rem; }
.kicker, figcaption, caption, footer { color: var(--soft); font-size: .87rem; }
.lead { font-size: 1.05rem; }
table { border-collapse: collapse; width: 100%; margin: .5rem 0; }
caption { text-align: left; }
th, td { text-align: right; padding: .22rem .5rem; border-bottom: 1px solid var(--rule);
  font-variant-numeric: tabular-nums; }
th { font-weight: 600; color: var(--soft); font-size: .87rem; }
th:first-child, td:first-child { text-align: left; }
tr.named td { font-weight: 600; }
.words td { text-align: left; vertical-align: top; }
.words td:first-child { color: var(--soft); white-space: nowrap; }
figure { margin: .8rem 0 1.2rem; }
svg { width: 100%; height: auto; display: block; }
svg text { fill: var(--soft); font-size: 11px; }
svg .tick, svg .label { text-anchor: middle; }
svg .side { text-anchor: end; }
svg .name { text-anchor: end; fill: var(--ink); font-size: 12px; dominant-baseline: middle; }
svg path { fill: none; }
svg .grid { stroke: var(--rule); stroke-width: .7; }
svg .measured { stroke: var(--ink); stroke-width: 1.1; }
svg .before { stroke: var(--before); stroke-width: 1.4; }
svg .after { stroke: var(--after); stroke-width: 1.6; stroke-dasharray: 5 3; }
svg .left { stroke: var(--after); stroke-width: 1; }
svg .one { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 2 3; }
svg .noise { fill: var(--noise); opacity: .45; }
svg .fitted { fill: var(--after); }
svg .held { fill: var(--noise); }
.key { display: inline-block; width: 1.6em; margin: 0 .35em 0 .9em; vertical-align: middle;
  border-top: 2px solid var(--ink); }
.key.before { border-color: var(--before); } .key.after { border-top: 2px dashed var(--after); }
.key.noise, .key.fitted, .key.held { height: .7em; border: 0; background: var(--noise); }
.key.fitted { background: var(--after); }
"""

MEANING = (
    "The gap is the mean of |measured − predicted|² over its expected random variance, taken over the FRFs "
    "and, where they were measured, the force and response spectra. The variance follows from coherence and "
    "the number of averages. A gap of 1 means that only random error is left; a gap of 100 means that the "
    "prediction is off by ten random errors on average. An effect is added only if the evidence for it is "
    "strong, if its size is clear of nothing by two standard errors, and if it also improves FRFs that took "
    "no part in the fit."
)

Row = Sequence[str]


def report(diagnosis: Diagnosis) -> str:
    """Return a diagnosis as one self-contained HTML page.

    It says what was missing, where and how sure, shows measured and predicted FRFs, and how to repeat it.
    """
    parts = [
        '<p class="kicker">Diagnosis of a modal test</p>',
        f"<h1>{escape(wording.headline(diagnosis))}</h1>",
        f'<p class="lead">{escape(wording.verdict(diagnosis))}</p>',
        _missing(diagnosis),
        _next_test(diagnosis),
        _gap_by_step(diagnosis),
        _located(diagnosis),
        all_curves(diagnosis.curves),
        _how_sure(diagnosis),
        f"<h2>What the gap means</h2><p>{escape(MEANING)}</p>",
        _repeat(diagnosis),
    ]
    head = (
        f'<meta charset="utf-8"/><meta name="viewport" content="width=device-width"/>'
        f"<title>{escape(wording.headline(diagnosis))}</title><style>{STYLE}</style>"
    )
    body = "\n".join(part for part in parts if part)
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def _table(head: Row, rows: Sequence[Row], *, named: int | None = None) -> str:
    top = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    lines = []
    for i, row in enumerate(rows):
        mark = ' class="named"' if i == named else ""
        lines.append(f"<tr{mark}>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>")
    return f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def _missing(diagnosis: Diagnosis) -> str:
    if not diagnosis.steps:
        return ""
    rows = [
        (
            wording.name(step.effect),
            wording.size(step.effect),
            wording.share(step.probability),
            wording.closing(step.gap_before, step.gap_after),
            wording.closing(step.held_out_gap_before, step.held_out_gap_after),
        )
        for step in diagnosis.steps
    ]
    kinds = dict.fromkeys(step.effect.kind for step in diagnosis.steps)
    meant = "; ".join(f"{kind.replace('_', ' ')}: {EFFECTS[kind].summary}" for kind in kinds)
    table = _table(("effect", "size", "probability", "gap", "gap, held out"), rows)
    return f"<h2>What was missing</h2>{table}<p class='kicker'>{escape(meant)}</p>"


def _next_test(diagnosis: Diagnosis) -> str:
    test = diagnosis.next_test
    if test is None:
        return ""
    change = ", ".join(f"{key.replace('_', ' ')}: {value}" for key, value in test.change.items())
    names = ", ".join(kind.replace("_", " ") for kind in test.separates)
    return (
        f"<h2>The next test</h2><p>Repeat the measurement with {escape(change)}: {escape(test.why)}. "
        f"It separates {escape(names)}.</p>"
    )


def _gap_by_step(diagnosis: Diagnosis) -> str:
    steps = diagnosis.steps
    if not steps:
        return ""
    names = ["as given", *(f"+ {wording.name(step.effect)}" for step in steps)]
    fitted = [steps[0].gap_before, *(step.gap_after for step in steps)]
    held = [steps[0].held_out_gap_before, *(step.held_out_gap_after for step in steps)]
    logs = np.log10(np.maximum([fitted, held], 1e-3)).T
    # From 0.1: a gap of 1, only random error left, is then a bar that can be seen.
    axis = svg.decades(min(-1.0, logs.min()), max(1.0, logs.max()), "gap (1: only random error left)")
    drawing = svg.bars(names, logs.tolist(), ("fitted", "held"), axis)
    legend = keys((("fitted", "FRFs that were fitted"), ("held", "FRFs held out of every fit")))
    parts = [
        (f"{part} spectra" if part != "frf" else "FRFs", wording.gap(before), wording.gap(after))
        for (part, before), after in zip(
            diagnosis.gaps["before"].items(), diagnosis.gaps["after"].values(), strict=True
        )
    ]
    table = _table(("gap by part, over all FRFs", "before", "after"), parts)
    return f"<h2>Gap by step</h2><figure>{drawing}<figcaption>{legend}</figcaption></figure>{table}"


def _located(diagnosis: Diagnosis) -> str:
    found = diagnosis.located
    rows = []
    if found.bands:
        bands = (
            f"{low:.4g} to {high:.4g} Hz" if high > low else f"{low:.4g} Hz" for low, high in found.bands
        )
        rows.append(("bands", ", ".join(bands)))
    if found.dofs:
        rows.append(("responses", ", ".join(map(str, found.dofs))))
    if found.modes:
        rows.append(("modes of the model", ", ".join(map(str, found.modes))))
    # Bands, responses and the gap by part have places of their own on this page.
    said = ("bands:", "responses:", "mean squared residual")
    rows += [("seen", words) for words in found.words if not words.startswith(said)]
    if not rows:
        return ""
    lines = "".join(f"<tr><td>{escape(key)}</td><td>{escape(text)}</td></tr>" for key, text in rows)
    return f"<h2>Where the model as given parts from the measurement</h2><table class='words'>{lines}</table>"


def _how_sure(diagnosis: Diagnosis) -> str:
    if not diagnosis.candidates:
        return ""
    rows = [_candidate(one) for one in diagnosis.candidates]
    first = diagnosis.steps[0].effect
    named = next(
        (i for i, one in enumerate(diagnosis.candidates) if (one.kind, one.at) == (first.kind, first.at)),
        None,
    )
    later = "".join(
        f"<p>Beside {escape(wording.name(step.effect))}, fitted in a later round:</p>"
        + _table(("explanation", "probability", "gap with it"), [_candidate(one) for one in step.rivals])
        for step in diagnosis.steps[1:]
        if step.rivals
    )
    words = (
        "Every kind of effect that was suspected was tried at every place it could have; the best were "
        "fitted in full, alone, and share the belief by how well they predict."
    )
    table = _table(("explanation", "probability", "gap with it"), rows, named=named)
    return f"<h2>How sure: what else was considered</h2><p>{words}</p>{table}{later}"


def _candidate(one: Rival) -> Row:
    return wording.name(one), wording.share(one.probability), wording.gap(one.gap_after)


def _repeat(diagnosis: Diagnosis) -> str:
    analyser = diagnosis.setup.analyser
    seed = "no seed was used" if diagnosis.seed is None else f"seed {diagnosis.seed}"
    held = [str(d) for d, out in zip(diagnosis.curves.outputs, diagnosis.curves.held_out, strict=True) if out]
    out = f" Held out of every fit: {', '.join(held)}." if held else ""
    words = (
        f"The same model, measurement, suspects and seed give the same diagnosis, digit for digit: {seed}."
        f"{out} The test: {len(diagnosis.curves.outputs)} responses to a force at {diagnosis.setup.drive}, "
        f"{analyser.n_lines} lines to {analyser.frequency_max:g} Hz, {analyser.averages} averages, "
        f"{analyser.excitation.kind.replace('_', ' ')} excitation, {analyser.window} window."
    )
    notes = "".join(f"<p>{escape(note)}</p>" for note in diagnosis.notes)
    return f"<h2>How to repeat it</h2><p>{escape(words)}</p>{notes}"
