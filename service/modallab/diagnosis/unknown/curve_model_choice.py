"""Choice of the model that an unknown cause follows, and of the motion that drives it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.diagnosis.unknown.curve import SmoothCurve
from modallab.diagnosis.unknown.curve_model_fit import CurveModelFit, fit_curve_model
from modallab.diagnosis.unknown.curve_models import (
    FEEDBACK_MODELS,
    GAIN_MODELS,
    STIFFNESS_MODELS,
    CurveModel,
    ModelEstimate,
    estimate,
)
from modallab.diagnosis.unknown.line_by_line import Influence, LineByLine
from modallab.diagnosis.unknown.places import Influences, UnknownPlace
from modallab.diagnosis.unknown.settings import UNKNOWN


@dataclass(frozen=True, eq=False)
class ChosenModel:
    """CurveModel of an unknown cause."""

    fit: CurveModelFit
    """The model, fitted to the FRFs."""
    influence: Influence
    """Influence of the cause that follows it."""
    source: Dof | None
    """DoF of the motion that it multiplies; None: of no motion."""


@dataclass(frozen=True, eq=False)
class LineCurve:
    """Values of an unknown cause at the lines that tell it."""

    freq: FloatArray
    """(n_freq,) Hz, ascending."""
    z: ComplexArray
    """(n_freq,) values."""
    error: FloatArray
    """(n_freq,) standard error of real and of imaginary part."""


_Candidate = tuple[ModelEstimate, Influence, Dof | None]


def choose_curve_model(
    lines: LineByLine,
    influences: Influences,
    place: UnknownPlace,
    step: FloatArray,
    freq: FloatArray,
    smooth: tuple[SmoothCurve, float],
    scale: float,
) -> ChosenModel | None:
    """Return the model that a cause at a place follows; None if none fits nearly as well as its smooth curve.

    Nearly as well: by the Bayesian information criterion; or, as the model is a little wrong, if it leaves
    little of what the curve closes. The models nearest to the curves line by line are fitted to the FRFs. A
    force by the motion of another DoF has to gain what the choice among all of them costs.

    Parameters
    ----------
    step
        (n,) of the nuisance parameters beside a cause of any curve: no motion of a DoF that may drive the
        force changes which force it is.
    freq
        (n_freq,) Hz, of the lines.
    smooth
        The smooth curve, and chi-square with it.
    scale
        Mean square of residuals that errors of the model leave.
    """
    candidates = sorted(
        _estimates(lines, influences, place, step, freq), key=lambda candidate: candidate[0].chi_square
    )
    n_data, n_sources = lines.n_data, len(influences.sources(place.at))
    without = lines.best_square(influences.of(place), np.zeros(len(freq), complex))
    as_good = smooth[1] + UNKNOWN.model_share * max(without - smooth[1], 0.0)
    cost = smooth[0].n_parameters * float(np.log(n_data))
    best, least = None, max(smooth[1] / scale + cost, as_good / scale)
    for nearest, influence, source in candidates[: UNKNOWN.refined_models]:
        found = fit_curve_model(lines, influence, nearest, freq, offset=_offset(place), scale=scale)
        if found is None:
            continue
        bic = found.chi_square / scale + len(found.parameters) * float(np.log(n_data))
        if source is not None and source != place.at:
            bic += 2 * float(np.log(n_sources))
        if bic < least:
            best, least = ChosenModel(found, influence, source), bic
    return best


def _estimates(
    lines: LineByLine, influences: Influences, place: UnknownPlace, step: FloatArray, freq: FloatArray
) -> Iterator[_Candidate]:
    """Yield each model near the curve of the cause, for each motion that may drive it."""
    offset = _offset(place)
    sources: Sequence[Dof | None] = influences.sources(place.at)
    for source in sources:
        models: Sequence[CurveModel] = FEEDBACK_MODELS
        if source is None:
            models = GAIN_MODELS
        elif source == place.at:
            models = STIFFNESS_MODELS
        influence = influences.driven_by(place, source)
        found = lines.fit(influence, step)
        told = np.isfinite(found.error) & (freq > 0)
        z, error = found.z[told] + offset, found.error[told]
        error = np.hypot(error, UNKNOWN.model_error * np.abs(z))
        for model in models:
            nearest = estimate(model, 2 * np.pi * freq[told], z, error)
            if nearest is not None:
                yield nearest, influence, source


def _offset(place: UnknownPlace) -> float:
    """Return what a model has more than the cause: of a gain, whose cause is its change, 1."""
    return 0.0 if isinstance(place.at, Dof) else 1.0
