"""Limitations of a measurement, one sentence each."""

from collections.abc import Iterator

import numpy as np

from modallab.core.frf import FrfKind
from modallab.diagnosis.predicting.settings import LIMITATIONS
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.free_levels import FreeLevels
from modallab.diagnosis.residuals.mains_lines import hum_frequencies
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
from modallab.extraction.preprocessing.reciprocity import reciprocity
from modallab.rig.measurement import Measurement


def limitations(measurement: Measurement, observed: Observed) -> tuple[str, ...]:
    """Return the limitations of a measurement, one sentence each.

    Parameters
    ----------
    measurement
        The measurement of the request.
    observed
        The spectra of it that a fit uses.
    """
    return (
        *_of_quantities(measurement),
        *_of_responses(measurement, observed),
        *_of_random_errors(measurement),
        *_of_levels(FreeLevels.of(measurement.setup, simulated=measurement.route is not None), observed),
        *_of_noise_reference(observed),
        *_of_hum(measurement),
        *_of_lines(observed),
    )


def _of_quantities(measurement: Measurement) -> Iterator[str]:
    frf = measurement.frf
    if frf.kind is not FrfKind.INERTANCE:
        yield f"the FRFs are {frf.kind.value}: compared as inertance, without 0 Hz"
    if len(frf.inputs) > 1:
        yield from _of_reciprocity(measurement)
    if len(frf.outputs) * len(frf.inputs) == 1:
        yield (
            "a single FRF: no other response can bear out what is named, nor tell the structure from the "
            "response's own channel"
        )
    if measurement.force_spectrum is None:
        yield "no force spectrum: what only the force shows, as the exciter's own mass, cannot be seen"


def _of_responses(measurement: Measurement, observed: Observed) -> Iterator[str]:
    if measurement.response_spectrum is not None:
        return
    compared = observed.incoherent is not None
    yield (
        "no response spectra: noise and leakage show in the coherence alone, which is "
        + ("compared with that of the declared noise" if compared else "not compared")
    )


def _of_reciprocity(measurement: Measurement) -> Iterator[str]:
    frf, n_in = measurement.frf, len(measurement.frf.inputs)
    if len(frf.outputs) == 1:
        yield (
            f"one response, {frf.outputs[0]}, to {_forces(measurement)}: by reciprocity as good as {n_in} "
            "responses to one force; reciprocity itself is not tested"
        )
        return
    compared = reciprocity(frf, coherence=measurement.frf_coherence, averages=measurement.averages)
    if not compared.pairs:
        struck = "struck" if measurement.setup.exciter.kind == "hammer" else "driven"
        yield f"no two points were both {struck} and measured: reciprocity is not tested"
        return
    names = [f"{first} and {second}" for first, second in compared.pairs]
    differences = [
        f"{name} by {100 * size:.2g} %" for name, size in zip(names, compared.difference, strict=True)
    ]
    if np.isnan(compared.misfit).all():
        largest = differences[int(compared.difference.argmax())]
        yield (
            f"reciprocity of {_pairs(len(names))} of points, random error unknown: "
            f"largest difference {largest}"
        )
        return
    differing = [text for text, differs in zip(differences, compared.differs, strict=True) if differs]
    if not differing:
        yield f"reciprocity tested with {_pairs(len(names))} of points: equal within random error"
        return
    shown = "; ".join(differing[: LIMITATIONS.max_pairs])
    more = ", ..." if len(differing) > LIMITATIONS.max_pairs else ""
    yield (
        f"not reciprocal at {len(differing)} of {_pairs(len(names))} of points: {shown}{more}; the model is "
        "reciprocal, so a transducer or its mass may differ from run to run"
    )


def _forces(measurement: Measurement) -> str:
    n_in = len(measurement.frf.inputs)
    return f"a hammer at {n_in} points" if measurement.setup.roving_hammer else f"{n_in} shakers at once"


def _of_levels(levels: FreeLevels, observed: Observed) -> Iterator[str]:
    kinds = [
        name
        for name, free in (("force_noise", levels.force_noise), ("response_noise", levels.response_noise))
        if free
    ]
    if kinds:
        kinds.append("quantisation")
        yield f"noise of the channels is not declared: fitted to the test, and {', '.join(kinds)} not judged"
    if levels.force_noise:
        yield (
            "the coherence does not distinguish noise of the force, which makes H1 low, from noise in "
            "proportion to the responses: how low the FRFs are decides between them"
        )
    if levels.shape:
        yield "the source's spectrum is not declared: a force is compared beside a smooth curve fitted to it"
    elif levels.source:
        yield "the source's level is not declared: a force is compared beside a level fitted to it"
    if not observed.level_known:
        yield "neither level nor force spectrum: the size of a nonlinear force needs a level, and is not told"


def _of_noise_reference(observed: Observed) -> Iterator[str]:
    noise = observed.free_levels.expected_force_noise
    if noise is None or observed.force is None:
        return
    lines = observed.usable.any(axis=1)
    ratio = float(observed.force[lines].mean() / noise.force[:, lines].mean())
    if abs(np.log(ratio)) > LIMITATIONS.other_force:
        yield (
            f"the mean force spectrum is {ratio:.2g} times the expected one: noise of the force, stated as a "
            "ratio, is fitted between that ratio to either"
        )


def _pairs(count: int) -> str:
    return "1 pair" if count == 1 else f"{count} pairs"


def _of_random_errors(measurement: Measurement) -> Iterator[str]:
    floor, estimator = measurement.noise_floor, measurement.setup.analyser.estimator
    if measurement.coherence is None or measurement.averages <= RANDOM_ERROR.min_averages:
        source = "that the scatter of its lines shows" if floor is None else f"stated, {floor:g} of itself"
        yield f"no usable coherence: every FRF is taken to have the random error {source}"
        if estimator != "h1":
            yield f"without coherence {estimator} cannot be turned into h1: compared as if it were"
        return
    if measurement.setup.n_simultaneous > 1 and measurement.force_cross_spectra is None:
        powers = "of equal power and " if measurement.force_spectrum is None else ""
        yield f"no cross spectra of the forces: random errors of FRFs as if they were {powers}uncorrelated"
    if floor is not None:
        yield f"beside the random error that coherence tells, every FRF is given one of {floor:g} of itself"
    if measurement.averages < LIMITATIONS.few_averages:
        yield f"{measurement.averages:g} averages: the random errors themselves are known poorly"


def _of_hum(measurement: Measurement) -> Iterator[str]:
    if measurement.route is not None:  # its hum is an effect like any other
        return
    responses = hum_frequencies(measurement.setup.analyser, ChannelSpectra.of(measurement))
    if responses:
        most, frequencies = max(responses.values()), ", ".join(f"{line:g}" for line in sorted(responses))
        yield (
            f"mains hum: the coherence of {most} of {len(measurement.frf.outputs)} responses "
            f"falls at {frequencies} Hz; these lines are given little weight"
        )


def _of_lines(observed: Observed) -> Iterator[str]:
    nonzero = observed.freq > 0
    incoherent = float((observed.coherence[nonzero] < LIMITATIONS.low_coherence).mean())
    if incoherent > LIMITATIONS.many_lines:
        low = LIMITATIONS.low_coherence
        yield f"{100 * incoherent:.0f} % of all lines have a coherence below {low:g}: they tell little"
    unusable = float((~observed.usable[nonzero]).mean())
    if unusable > LIMITATIONS.many_lines:
        yield f"{100 * unusable:.0f} % of all lines show no response and are left out"
    if observed.held_out_lines.any():
        yield "too few FRFs to hold some out of the fit: lines are held out instead"
