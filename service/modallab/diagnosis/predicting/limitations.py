"""What a test cannot tell, in plain words: said beside what it does."""

from collections.abc import Iterator

from modallab.core.frf import FrfKind
from modallab.diagnosis.residuals.observed import Observed
from modallab.rig.measurement import Measurement

FEW_AVERAGES = 10  # below, random errors themselves are known to a third or worse
UNSURE = 0.3  # coherence below which an FRF is hardly known
MANY = 0.1  # share of the lines


def limitations(measurement: Measurement, observed: Observed) -> tuple[str, ...]:
    """Return what the measurement cannot tell, one sentence each.

    Parameters
    ----------
    measurement
        As it was handed in.
    observed
        What the fit sees of it.
    """
    return (*_of_what_came(measurement), *_of_errors(measurement), *_of_lines(observed))


def _of_what_came(measurement: Measurement) -> Iterator[str]:
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


def _of_errors(measurement: Measurement) -> Iterator[str]:
    floor, estimator = measurement.noise_floor, measurement.setup.analyser.estimator
    if measurement.coherence is None or measurement.averages <= 2:
        yield f"no usable coherence: every FRF is taken to have the random error stated, {floor:g} of itself"
        if estimator != "h1":
            yield f"without coherence {estimator} cannot be turned into h1: compared as if it were"
        return
    if floor is not None:
        yield f"beside the random error that coherence tells, every FRF is given one of {floor:g} of itself"
    if measurement.averages < FEW_AVERAGES:
        yield f"{measurement.averages:g} averages: the random errors themselves are known poorly"


def _of_lines(observed: Observed) -> Iterator[str]:
    above = observed.freq > 0
    unsure = float((observed.coherence[above] < UNSURE).mean())
    if unsure > MANY:
        yield f"{100 * unsure:.0f} % of all lines have a coherence below {UNSURE:g}: they tell little"
    unseen = float((~observed.usable[above]).mean())
    if unseen > MANY:
        yield f"{100 * unseen:.0f} % of all lines show no response and are left out"
    if observed.held_out_lines.any():
        yield "too few FRFs to hold some out of the fit: lines are held out instead"
