"""Report of a diagnosis: one self-contained HTML page with statements, tables and drawings."""

import json
from collections.abc import Mapping
from html import escape

import numpy as np

from modallab.diagnosis.localisation.text import PATTERNS_WITHOUT_MODES
from modallab.diagnosis.reporting import svg
from modallab.diagnosis.reporting.figures import all_curves, enlarged
from modallab.diagnosis.reporting.heading import NO_HEADING, ReportHeading, heading_line
from modallab.diagnosis.reporting.legend import keys
from modallab.diagnosis.reporting.location_plot import location_drawings
from modallab.diagnosis.reporting.page import Row, page, paragraph, table
from modallab.diagnosis.reporting.settings import REPORT
from modallab.diagnosis.reporting.spectra_plot import spectra_drawings
from modallab.diagnosis.reporting.text import (
    changes_text,
    detection_limit_row,
    effect_name,
    equivalence_statement,
    gap_reduction,
    gap_text,
    kind_name,
    location_statements,
    next_test_text,
    parameter_rows,
    place_description,
    probability_text,
    shift_text,
    tolerated_rows,
)
from modallab.diagnosis.reporting.unknown_effect import unknown_section
from modallab.diagnosis.reporting.verdict_text import headline, verdict_text
from modallab.diagnosis.result import Diagnosis, Rival, Verdict
from modallab.rig.effect import EFFECTS
from modallab.rig.setup import RigSetup

DEFINITION = (
    "A residual is the logarithm of measured over predicted, divided by its random error, which follows "
    "from the coherence and the number of averages. The gap is the mean squared residual over the frequency "
    "response functions (FRFs) and, where they were measured, the force and response spectra. A gap of 1 "
    "means that only random error remains; a gap of 100 means that the prediction deviates by ten random "
    "errors on average."
)
ACCEPTANCE = (
    "An effect is added only if the evidence for it is strong, if its size differs from that of an absent "
    "effect by two standard errors, and if it also improves the prediction of FRFs that took no part in the "
    "fit. The number after ± is one standard deviation."
)
LOW_PROBABILITY = (
    "The probability of an effect refers to its own round, before the other effects were found. It is low if "
    "another effect explained more by itself in that round; it says nothing about the combination."
)
COMBINATION = "No single effect explains the measurement; the named effects do so together."
WITHIN_TOLERANCES = (
    "What follows compares the test with model and log book as they were declared. Deviations within the "
    "tolerances account for the differences."
)
TOLERANCES = (
    "These nuisance parameters were fitted within their tolerances together with the effects; they are not "
    "missing effects. The value is true over declared; for a delay, the time by which the channel lags."
)
DETECTION_LIMITS = (
    "This measurement would show each of these effects from this amount on in 98 of 100 tests, whatever the "
    "parameters within tolerances are. Smaller effects may be present. The amount is the deviation "
    "from that of no effect."
)
CONSIDERED = (
    "Every suspected kind of effect was tried at every possible place. The best candidates were fitted in "
    "full, one at a time; their probabilities follow from how well they predict the measurement. A cause "
    "outside the list of suspects cannot be named."
)


def report(
    diagnosis: Diagnosis,
    provenance: Mapping[str, str] | None = None,
    heading: ReportHeading = NO_HEADING,
) -> str:
    """Return a diagnosis as one self-contained HTML page.

    The page states the missing effects with their places, sizes and probabilities, shows measured and
    predicted FRFs, and tells how to repeat the diagnosis.

    Parameters
    ----------
    provenance
        Origin of the diagnosis: `id`, `created`, `version`, `structure_id`, `measurement_id`; or the `call`
        that made it.
    heading
        Title, object, author and date.
    """
    title, added = headline(diagnosis), bool(diagnosis.steps)
    parts = [
        paragraph(heading.title or "Diagnosis of a modal test", "soft"),
        f"<h1>{escape(title)}</h1>",
        heading_line(heading),
        paragraph(verdict_text(diagnosis), "lead"),
        _missing_effects(diagnosis),
        unknown_section(diagnosis.unknown),
        _next_test(diagnosis),
        _location(diagnosis),
        enlarged(diagnosis.curves, added=added),
        _gap_by_step(diagnosis),
        spectra_drawings(diagnosis.curves, added=added),
        all_curves(diagnosis.curves, added=added),
        _candidates(diagnosis),
        _tolerances(diagnosis),
        _detection_limits(diagnosis),
        f"<h2>Definition of the gap</h2>{paragraph(DEFINITION)}{paragraph(ACCEPTANCE)}",
        _repetition(diagnosis, provenance or {}),
    ]
    return page(title, parts)


def _missing_effects(diagnosis: Diagnosis) -> str:
    """Return the added effects as a table, with explanations."""
    if not diagnosis.steps:
        return ""
    rows = []
    for step in diagnosis.steps:
        effect = step.effect
        place = place_description(effect.at, diagnosis.structure)
        if effect.at is None and not EFFECTS[effect.kind].structural:
            place = "the rig"
        sizes = "; ".join(f"{name} {text}" for name, text in parameter_rows(effect)) or "\N{EM DASH}"
        reductions = (
            gap_reduction(step.gap_before, step.gap_after),
            gap_reduction(step.held_out_gap_before, step.held_out_gap_after),
        )
        rows.append((kind_name(effect.kind), place, sizes, probability_text(step.probability), *reductions))
    kinds = dict.fromkeys(step.effect.kind for step in diagnosis.steps)
    definitions = [f"{kind_name(kind)}: {EFFECTS[kind].summary}" for kind in kinds]
    definition_list = "".join(f"<li>{escape(text)}</li>" for text in definitions)
    notes = "".join(
        paragraph(f"{effect_name(step.effect).capitalize()}: {equivalence_statement(step)}.")
        for step in diagnosis.steps
        if step.rivals_alike
    )
    head = ("effect", "place", "size", "probability", "gap", "gap, held out")
    effects = table(head, rows, n_text_columns=3, style="cards")
    least = min(step.probability for step in diagnosis.steps)
    if len(diagnosis.steps) > 1 and least < REPORT.even_probability:
        notes += paragraph(LOW_PROBABILITY, "soft")
    unsure = diagnosis.verdict in (Verdict.UNEXPLAINED, Verdict.PARTLY_EXPLAINED)
    title = "Added effects" if unsure else "Missing effects"
    return f"<h2>{title}</h2>{effects}<ul class='soft'>{definition_list}</ul>{notes}"


def _tolerances(diagnosis: Diagnosis) -> str:
    if not diagnosis.tolerated:
        return ""
    rows = tolerated_rows(diagnosis.tolerated)
    fitted = table(("parameter", "fitted", "tolerance"), rows)
    return f"<h2>Parameters within tolerances</h2>{paragraph(TOLERANCES)}{fitted}"


def _detection_limits(diagnosis: Diagnosis) -> str:
    if not diagnosis.detection_limits:
        return ""
    rows = [detection_limit_row(limit) for limit in diagnosis.detection_limits]
    head = ("effect", "amount", "detection limit", "at the least visible place")
    return f"<h2>Detection limits</h2>{paragraph(DETECTION_LIMITS)}{table(head, rows, n_text_columns=2)}"


def _next_test(diagnosis: Diagnosis) -> str:
    if diagnosis.next_test is None:
        return ""
    return f"<h2>Next test</h2><div class='next'>{paragraph(next_test_text(diagnosis.next_test))}</div>"


def _gap_by_step(diagnosis: Diagnosis) -> str:
    gaps_by_part = [
        (f"{part} spectra" if part != "frf" else "FRFs", gap_text(initial), gap_text(final))
        for (part, initial), final in zip(
            diagnosis.gaps["before"].items(), diagnosis.gaps["after"].values(), strict=True
        )
    ]
    steps = diagnosis.steps
    if not steps:
        remaining = table(("gap by part, over all FRFs", "gap"), [row[:2] for row in gaps_by_part])
        return f"<h2>Gap</h2>{remaining}"
    names = ["initial model", *(f"+ {effect_name(step.effect)}" for step in steps)]
    fitted = [steps[0].gap_before, *(step.gap_after for step in steps)]
    held_out = [steps[0].held_out_gap_before, *(step.held_out_gap_after for step in steps)]
    logs = np.log10(np.maximum([fitted, held_out], 1e-3)).T
    # The axis begins at 0.1, so that a gap of 1 is a visible bar.
    axis = svg.decades(min(-1.0, logs.min()), max(1.0, logs.max()), "gap (1: random error only)")
    drawing = svg.bars(names, logs.tolist(), ("fitted", "held"), axis)
    legend = keys((("fitted", "fitted FRFs"), ("held", "held-out FRFs")))
    by_part = table(("gap by part, over all FRFs", "before", "after"), gaps_by_part)
    figure = f"<figure>{drawing}<figcaption>{legend}</figcaption></figure>"
    return f'<h2>Gap by step</h2><div class="two">{figure}{by_part}</div>'


def _location(diagnosis: Diagnosis) -> str:
    """Return where model and measurement disagree, as statements, drawings and a table of modes."""
    sentences = [f"{text[:1].upper()}{text[1:]}." for text in location_statements(diagnosis.located)]
    items = "".join(f"<li>{escape(text)}</li>" for text in sentences)
    statements = f"<ul>{items}</ul>" if items else ""
    heading, note = "Disagreement of model and measurement", ""
    if diagnosis.verdict is Verdict.NOTHING_MISSING:
        heading = "Model and measurement agree"
        if diagnosis.tolerated:
            heading, note = "Differences within the tolerances", paragraph(WITHIN_TOLERANCES)
    drawings = f"{location_drawings(diagnosis)}{_mode_shifts(diagnosis)}"
    return f"<h2>{heading}</h2>{note}{statements}{drawings}"


def _mode_shifts(diagnosis: Diagnosis) -> str:
    """Return the shifts of the modes against the model as a table, if any is significant."""
    shifts = diagnosis.located.mode_shifts
    significant = [
        abs(value) > REPORT.shift_significance * error
        for shift in shifts
        for value, error in (
            (shift.frequency_shift, shift.frequency_error),
            (shift.loss_factor_shift, shift.loss_factor_error),
        )
    ]
    if not any(significant) or PATTERNS_WITHOUT_MODES & set(diagnosis.located.signs):
        return ""
    rows = [
        (
            str(shift.mode),
            f"{shift.frequency:.4g}",
            shift_text(shift.frequency_shift, shift.frequency_error),
            shift_text(shift.loss_factor_shift, shift.loss_factor_error),
        )
        for shift in shifts
    ]
    head = ("elastic mode", "model, Hz", "frequency shift", "loss factor shift")
    return table(head, rows)


def _candidates(diagnosis: Diagnosis) -> str:
    """Return the explanations of every round with their probabilities."""
    if not diagnosis.candidates:
        return ""
    rows = [_candidate_row(rival) for rival in diagnosis.candidates]
    first = diagnosis.steps[0].effect
    places = [(rival.kind, rival.at) for rival in diagnosis.candidates]
    named_row = places.index((first.kind, first.at)) if (first.kind, first.at) in places else None
    head = ("explanation", "probability", "gap with it")
    later_rounds = "".join(
        paragraph(f"Rivals of {effect_name(step.effect)}, fitted in a later round:")
        + table(head, [_candidate_row(rival) for rival in step.rivals])
        for step in diagnosis.steps[1:]
        if step.rivals
    )
    words = f"{CONSIDERED} {COMBINATION}" if len(diagnosis.steps) > 1 else CONSIDERED
    return (
        f"<h2>Other explanations considered</h2>{paragraph(words)}"
        f"{table(head, rows, highlighted=named_row)}{later_rounds}"
    )


def _candidate_row(rival: Rival) -> Row:
    return effect_name(rival), probability_text(rival.probability), gap_text(rival.gap_after)


def _repetition(diagnosis: Diagnosis, provenance: Mapping[str, str]) -> str:
    analyser, curves = diagnosis.setup.analyser, diagnosis.curves
    seed = "no seed was used" if diagnosis.seed is None else f"seed {diagnosis.seed}"
    frfs, roving_hammer = curves.by_frf, diagnosis.setup.roving_hammer
    names = [
        frfs.name(i) if roving_hammer else str(frfs.outputs[i])
        for i in np.flatnonzero(frfs.held_out).tolist()
    ]
    held_out = dict.fromkeys(names)
    drive = _drive(diagnosis.setup)
    exclusion = f" Held out of every fit: {', '.join(held_out)}." if held_out else ""
    test = (
        f"Test: {len(curves.outputs)} responses to {drive}, "
        f"{len(curves.freq)} lines from {curves.freq[0]:g} to {curves.freq[-1]:g} Hz, "
        f"{analyser.averages} averages, "
        f"{analyser.excitation.kind.replace('_', ' ')} excitation, {analyser.window} window.{exclusion}"
    )
    follow_ups = "".join(
        paragraph(f"A further test was explained together with it, with {changes_text(change)}.")
        for change in diagnosis.follow_ups
    )
    reproducibility = f"The same model, measurement, options and seed give an identical diagnosis: {seed}."
    notes = "".join(paragraph(note) for note in diagnosis.notes)
    request = _request_box(diagnosis, provenance)
    return f"<h2>Repetition</h2>{paragraph(reproducibility)}{request}{paragraph(test)}{follow_ups}{notes}"


def _drive(setup: RigSetup) -> str:
    if setup.roving_hammer:
        return f"a hammer at {len(setup.drives)} points"
    points = ", ".join(map(str, setup.drives))
    return f"simultaneous forces at {points}" if setup.n_simultaneous > 1 else f"a force at {points}"


def _request_box(diagnosis: Diagnosis, provenance: Mapping[str, str]) -> str:
    call = provenance.get("call") or _request(diagnosis, provenance)
    if not call:
        return ""
    labels = {"diagnosis": "id", "of": "created", "by modallab": "version"}
    origin = ", ".join(f"{label} {provenance[key]}" for label, key in labels.items() if provenance.get(key))
    return f'<div class="call">{escape(call)}</div>{paragraph(f"{origin}.", "soft") if origin else ""}'


def _request(diagnosis: Diagnosis, provenance: Mapping[str, str]) -> str:
    ids = {name: provenance[name] for name in ("structure_id", "measurement_id") if name in provenance}
    if not ids:
        return ""
    options: dict[str, object] = {**diagnosis.request_options, "seed": diagnosis.seed}
    if diagnosis.follow_ups:
        options["follow_ups"] = [
            {"measurement_id": provenance.get(f"follow_up_{i}"), "changed": dict(change)}
            for i, change in enumerate(diagnosis.follow_ups, 1)
        ]
    return f"POST /v1/diagnoses\n{json.dumps(ids | options)}"
