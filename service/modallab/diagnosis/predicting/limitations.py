"""Limitations of a measurement, one sentence each."""

from collections.abc import Iterator

from modallab.core.frf import FrfKind
from modallab.diagnosis.predicting.settings import LIMITATIONS
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
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
    return (*_of_quantities(measurement), *_of_random_errors(measurement), *_of_lines(observed))


def _of_quantities(measurement: Measurement) -> Iterator[str]:
    frf = measurement.frf
    if frf.kind is not FrfKind.INERTANCE:
        yield f"the FRFs are {frf.kind.value}: compared as inertance, without 0 Hz"
    if len(frf.outputs) == 1:
        yield (
            "a single FRF: no other response can bear out what is named, nor tell the structure from the "
            "response's own channel"
        )
    if measurement.force_spectrum is None:
        yield "no force spectrum: what only the force shows, as the exciter's own mass, cannot be seen"
    if measurement.response_spectrum is None:
        yield "no response spectra: noise and leakage show in the coherence alone, which is not compared"


def _of_random_errors(measurement: Measurement) -> Iterator[str]:
    floor, estimator = measurement.noise_floor, measurement.setup.analyser.estimator
    if measurement.coherence is None or measurement.averages <= RANDOM_ERROR.min_averages:
        yield f"no usable coherence: every FRF is taken to have the random error stated, {floor:g} of itself"
        if estimator != "h1":
            yield f"without coherence {estimator} cannot be turned into h1: compared as if it were"
        return
    if floor is not None:
        yield f"beside the random error that coherence tells, every FRF is given one of {floor:g} of itself"
    if measurement.averages < LIMITATIONS.few_averages:
        yield f"{measurement.averages:g} averages: the random errors themselves are known poorly"


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
