"""A diagnosis as one page: words, tables, curves; nothing is fetched and nothing is run."""

import json
from collections.abc import Mapping
from html import escape

import numpy as np

from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting import text as wording
from modallab.diagnosis.reporting.figures import all_curves, enlarged
from modallab.diagnosis.reporting.legend import keys
from modallab.diagnosis.reporting.location_plot import where_drawn
from modallab.diagnosis.reporting.page import Row, page, paragraph, table
from modallab.diagnosis.reporting.spectra_plot import spectra_drawn
from modallab.diagnosis.result import Diagnosis, GapPattern, Rival, Verdict
from modallab.rig.effect import EFFECTS

EVEN = 0.5  # probability below which something else was believed more
CLEAR = 4.0  # standard errors from which on a shift of a mode is worth a table
# One response alone cannot say that the modes of a structure are elsewhere, nor can FRFs that agree.
NOT_THE_MODES = {
    GapPattern.FORCE_ONLY,
    GapPattern.COHERENCE_ONLY,
    GapPattern.ONE_RESPONSE,
    GapPattern.DRIVE_POINT_ONLY,
}
MEANING = (
    "Every residual is the logarithm of measured over predicted, in units of its own random error, which "
    "follows from coherence and the number of averages. The gap is the mean of their squares, over the FRFs "
    "and, where they were measured, the force and response spectra. A gap of 1 means that only random error "
    "is left; a gap of 100 means that the prediction is off by ten random errors on average."
)
ACCEPTED = (
    "An effect is added only if the evidence for it is strong, if its size is clear of nothing by two "
    "standard errors, and if it also improves FRFs that took no part in the fit. An error behind a ± is one "
    "standard deviation."
)
ALONE = (
    "A low probability here means that in its own round, before the others were found, something else "
    "explained more alone; it does not weigh what they explain together."
)
TOGETHER = "None of them explains the measurement alone; what was named does so together."
TOLERATED = (
    "These were left free within their tolerances, beside everything that was fitted, and are no missing "
    "effects. True over declared; of a delay, how late the channel is."
)
CONSIDERED = (
    "Every kind of effect that was suspected was tried at every place it could have; the best were fitted in "
    "full, alone, and share the belief by how well they predict. A cause that is on no list cannot be named."
)


def report(diagnosis: Diagnosis, made: Mapping[str, str] | None = None) -> str:
    """Return a diagnosis as one self-contained HTML page.

    It says what was missing, where and how sure, shows measured and predicted FRFs, and how to repeat it.

    Parameters
    ----------
    made
        What is known of how it was made: `id`, `created`, `version`, `structure_id`, `measurement_id`; or
        the `call` that made it.
    """
    headline, added = wording.headline(diagnosis), bool(diagnosis.steps)
    parts = [
        paragraph("Diagnosis of a modal test", "soft"),
        f"<h1>{escape(headline)}</h1>",
        paragraph(wording.verdict(diagnosis), "lead"),
        _missing(diagnosis),
        _next_test(diagnosis),
        _located(diagnosis),
        enlarged(diagnosis.curves, added=added),
        _gap_by_step(diagnosis),
        spectra_drawn(diagnosis.curves, added=added),
        all_curves(diagnosis.curves, added=added),
        _how_sure(diagnosis),
        _tolerated(diagnosis),
        f"<h2>What the gap means</h2>{paragraph(MEANING)}{paragraph(ACCEPTED)}",
        _repeat(diagnosis, made or {}),
    ]
    return page(headline, parts)


def _missing(diagnosis: Diagnosis) -> str:
    if not diagnosis.steps:
        return ""
    rows = []
    for step in diagnosis.steps:
        closing = (
            wording.closing(step.gap_before, step.gap_after),
            wording.closing(step.held_out_gap_before, step.held_out_gap_after),
        )
        effect = step.effect
        place = wording.where(effect.at, diagnosis.structure)
        if effect.at is None and not EFFECTS[effect.kind].structural:
            place = "the rig"
        numbers = "; ".join(f"{name} {text}" for name, text in wording.numbers(effect)) or "\N{EM DASH}"
        rows.append(
            (effect.kind.replace("_", " "), place, numbers, wording.share(step.probability), *closing)
        )
    kinds = dict.fromkeys(step.effect.kind for step in diagnosis.steps)
    told = [f"{kind.replace('_', ' ')}: {EFFECTS[kind].summary}" for kind in kinds]
    meant = "".join(f"<li>{escape(text)}</li>" for text in told)
    alike = "".join(
        paragraph(f"{wording.name(step.effect).capitalize()}: {wording.alike(step)}.")
        for step in diagnosis.steps
        if step.rivals_alike
    )
    head = ("effect", "where", "size", "probability", "gap", "gap, held out")
    named = table(head, rows, words=3, style="cards")
    if len(diagnosis.steps) > 1 and min(step.probability for step in diagnosis.steps) < EVEN:
        alike += paragraph(ALONE, "soft")
    title = "What was added" if diagnosis.verdict is Verdict.UNEXPLAINED else "What was missing"
    return f"<h2>{title}</h2>{named}<ul class='soft'>{meant}</ul>{alike}"


def _tolerated(diagnosis: Diagnosis) -> str:
    if not diagnosis.tolerated:
        return ""
    rows = [wording.tolerated(one) for one in diagnosis.tolerated]
    found = table(("number", "fitted", "tolerance"), rows)
    return f"<h2>What may differ a little</h2>{paragraph(TOLERATED)}{found}"


def _next_test(diagnosis: Diagnosis) -> str:
    if diagnosis.next_test is None:
        return ""
    return (
        f"<h2>The next test</h2><div class='next'>{paragraph(wording.next_test(diagnosis.next_test))}</div>"
    )


def _gap_by_step(diagnosis: Diagnosis) -> str:
    parts = [
        (f"{part} spectra" if part != "frf" else "FRFs", wording.gap(before), wording.gap(after))
        for (part, before), after in zip(
            diagnosis.gaps["before"].items(), diagnosis.gaps["after"].values(), strict=True
        )
    ]
    steps = diagnosis.steps
    if not steps:
        left = table(("the gap by part, over all FRFs", "gap"), [row[:2] for row in parts])
        return f"<h2>The gap</h2>{left}"
    names = ["as given", *(f"+ {wording.name(step.effect)}" for step in steps)]
    fitted = [steps[0].gap_before, *(step.gap_after for step in steps)]
    held = [steps[0].held_out_gap_before, *(step.held_out_gap_after for step in steps)]
    logs = np.log10(np.maximum([fitted, held], 1e-3)).T
    # From 0.1: a gap of 1, only random error left, is then a bar that can be seen.
    axis = svg.decades(min(-1.0, logs.min()), max(1.0, logs.max()), "gap (1: only random error left)")
    drawing = svg.bars(names, logs.tolist(), ("fitted", "held"), axis)
    legend = keys((("fitted", "FRFs that were fitted"), ("held", "FRFs held out of every fit")))
    by_part = table(("the gap by part, over all FRFs", "before", "after"), parts)
    figure = f"<figure>{drawing}<figcaption>{legend}</figcaption></figure>"
    return f'<h2>The gap by step</h2><div class="two">{figure}{by_part}</div>'


def _located(diagnosis: Diagnosis) -> str:
    words = [f"{text[:1].upper()}{text[1:]}." for text in wording.whereabouts(diagnosis.located)]
    told = "".join(f"<li>{escape(text)}</li>" for text in words)
    listed = f"<ul>{told}</ul>" if told else ""
    heading = "Where the model as given parts from the measurement"
    if diagnosis.verdict is Verdict.NOTHING_MISSING:
        heading = "Model and measurement part nowhere"
    return f"<h2>{heading}</h2>{listed}{where_drawn(diagnosis)}{_modes(diagnosis)}"


def _modes(diagnosis: Diagnosis) -> str:
    """Return how resonances differ from the model's, where the FRFs tell."""
    shifts = diagnosis.located.mode_shifts
    clear = [
        abs(value) > CLEAR * error
        for one in shifts
        for value, error in (
            (one.frequency_shift, one.frequency_error),
            (one.loss_factor_shift, one.loss_factor_error),
        )
    ]
    if not any(clear) or NOT_THE_MODES & set(diagnosis.located.signs):
        return ""
    rows = [
        (
            str(one.mode),
            f"{one.frequency:.4g}",
            wording.shift(one.frequency_shift, one.frequency_error),
            wording.shift(one.loss_factor_shift, one.loss_factor_error),
        )
        for one in shifts
    ]
    head = ("elastic mode", "model, Hz", "frequency, measured against it", "loss factor")
    return table(head, rows)


def _how_sure(diagnosis: Diagnosis) -> str:
    if not diagnosis.candidates:
        return ""
    rows = [_candidate(one) for one in diagnosis.candidates]
    first = diagnosis.steps[0].effect
    named = next(
        (i for i, one in enumerate(diagnosis.candidates) if (one.kind, one.at) == (first.kind, first.at)),
        None,
    )
    head = ("explanation", "probability", "gap with it")
    later = "".join(
        paragraph(f"Beside {wording.name(step.effect)}, fitted in a later round:")
        + table(head, [_candidate(one) for one in step.rivals])
        for step in diagnosis.steps[1:]
        if step.rivals
    )
    words = f"{CONSIDERED} {TOGETHER}" if len(diagnosis.steps) > 1 else CONSIDERED
    return (
        f"<h2>How sure: what else was considered</h2>{paragraph(words)}"
        f"{table(head, rows, named=named)}{later}"
    )


def _candidate(one: Rival) -> Row:
    return wording.name(one), wording.share(one.probability), wording.gap(one.gap_after)


def _repeat(diagnosis: Diagnosis, made: Mapping[str, str]) -> str:
    analyser, curves = diagnosis.setup.analyser, diagnosis.curves
    seed = "no seed was used" if diagnosis.seed is None else f"seed {diagnosis.seed}"
    held = [str(d) for d, out in zip(curves.outputs, curves.held_out, strict=True) if out]
    out = f" Held out of every fit: {', '.join(held)}." if held else ""
    test = (
        f"The test: {len(curves.outputs)} responses to a force at {diagnosis.setup.drive}, "
        f"{analyser.n_lines} lines to {analyser.frequency_max:g} Hz, {analyser.averages} averages, "
        f"{analyser.excitation.kind.replace('_', ' ')} excitation, {analyser.window} window.{out}"
    )
    further = "".join(
        paragraph(f"A further test was explained together with it, with {wording.follow_up(change)}.")
        for change in diagnosis.follow_ups
    )
    same = f"The same model, measurement, options and seed give the same diagnosis, digit for digit: {seed}."
    notes = "".join(paragraph(note) for note in diagnosis.notes)
    return (
        f"<h2>How to repeat it</h2>{paragraph(same)}{_call(diagnosis, made)}{paragraph(test)}{further}{notes}"
    )


def _call(diagnosis: Diagnosis, made: Mapping[str, str]) -> str:
    call = made.get("call") or _request(diagnosis, made)
    if not call:
        return ""
    told = {"diagnosis": made.get("id"), "of": made.get("created"), "by modallab": made.get("version")}
    origin = ", ".join(f"{name} {value}" for name, value in told.items() if value)
    return f'<div class="call">{escape(call)}</div>{paragraph(f"{origin}.", "soft") if origin else ""}'


def _request(diagnosis: Diagnosis, made: Mapping[str, str]) -> str:
    given = {name: made[name] for name in ("structure_id", "measurement_id") if name in made}
    if not given:
        return ""
    more: dict[str, object] = {**diagnosis.request_options, "seed": diagnosis.seed}
    if diagnosis.follow_ups:
        more["follow_ups"] = [
            {"measurement_id": made.get(f"follow_up_{i}"), "changed": dict(change)}
            for i, change in enumerate(diagnosis.follow_ups, 1)
        ]
    return f"POST /v1/diagnoses\n{json.dumps(given | more)}"
