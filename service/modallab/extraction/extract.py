"""Extraction of a modal model from measured responses, by any method."""

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Protocol

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, part, silent
from modallab.extraction.averaging.damping_model import select_damping_model, with_damping_model
from modallab.extraction.method_options import options_for
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.multi_mode_extraction import extract_globally
from modallab.extraction.options import Damping, ExtractionOptions
from modallab.extraction.preprocessing.leakage import WindowLeakage, noise_bias_of
from modallab.extraction.preprocessing.low_coherence import low_coherence_notes
from modallab.extraction.preprocessing.noise_bias import (
    leaked_force_noise,
    noise_to_signal,
    without_noise_bias,
)
from modallab.extraction.preprocessing.responses import Responses, responses_of
from modallab.extraction.preprocessing.white_forces import white_forces_notes
from modallab.extraction.settings import PROGRESS_SHARES
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.extraction.single_mode_extraction import extract_mode_by_mode


class Read(Protocol):
    """Extraction with given options."""

    def __call__(self, *, options: ExtractionOptions, progress: Progress) -> ModalModel:
        """Return the modal model."""
        ...


def extract(
    frf: FrfSet,
    *,
    coherence: FloatArray | None,
    averages: float,
    method: str = "dobson",
    options: ExtractionOptions | None = None,
    bands: Sequence[tuple[float, float]] | None = None,
    n_modes: int | None = None,
    leakage: WindowLeakage | None = None,
    estimator: str | None = None,
    progress: Progress = silent,
) -> ModalModel:
    """Return the modes that a set of FRFs shows.

    Parameters
    ----------
    frf
        Of any kind: from one drive point or several, or to one response or several from a roving drive point.
    coherence
        (n_freq, n_out), multiple where several forces act at once, or (n_freq, n_out, n_in); None where it
        was not measured: then the misfit of the fits stands in for the random error.
    averages
        Effective number of averages behind the coherence.
    method
        A member of `EXTRACTION_METHODS`, mode by mode in every FRF, or of `GLOBAL_METHODS`, all at once.
    options
        Options of the method, or those common to several; by default all are chosen from the data.
    bands
        Pairs (lower, upper) in Hz with one mode each, of a global method one or more; found from the FRFs
        by default.
    n_modes
        How many of the modes found to keep, the most prominent ones.
    leakage
        What window cut the random records and which estimator was used; None for records that are periodic,
        or die out, within the window.
    estimator
        "h1", "h2" or "hv": each is biased by noise in a way of its own, which is taken off; None where it
        is not known.
    progress
        Told what is being done.

    Raises
    ------
    NoModeInBandError
        If a band given holds no mode, or no mode is found at all.
    InvalidInputError
        If the inputs do not fit together.
    """
    if n_modes is not None and n_modes < 1:
        raise InvalidInputError("at least one mode", field="n_modes", value=n_modes, allowed=bounds(1))
    requested = options_for(method, options)
    responses, bias = responses_read(frf, coherence, averages, leakage=leakage, estimator=estimator)
    if method in GLOBAL_METHODS:
        read: Read = partial(
            extract_globally,
            GLOBAL_METHODS[method].find,
            responses,
            method=method,
            bands=bands,
            n_modes=n_modes,
            leakage=leakage,
            bias=bias,
        )
    else:
        read = partial(
            extract_mode_by_mode,
            EXTRACTION_METHODS[method],
            responses,
            method=method,
            bands=bands,
            n_modes=n_modes,
            leakage=leakage,
        )
    if requested.damping is None and (method in GLOBAL_METHODS or EXTRACTION_METHODS[method].exact):
        model = _by_identified_damping_model(read, requested, progress)
    else:
        model = read(options=requested, progress=progress)
    warned = (*low_coherence_notes(model, responses), *white_forces_notes(responses, leakage))
    return replace(model, notes=(*model.notes, *warned), options=asdict(requested))


def _by_identified_damping_model(read: Read, options: ExtractionOptions, progress: Progress) -> ModalModel:
    """Return the modes with the damping model that they indicate, structural where they do not decide."""
    model = read(options=options, progress=part(progress, 0.0, PROGRESS_SHARES.structural_fit))
    choice = select_damping_model(model)
    if choice.damping is Damping.VISCOUS:
        viscous = replace(options, damping=choice.damping)
        model = read(options=viscous, progress=part(progress, PROGRESS_SHARES.structural_fit, 1.0))
    progress(1.0, "damping model determined")
    return with_damping_model(model, choice)


def responses_read(
    frf: FrfSet,
    coherence: FloatArray | None,
    averages: float,
    *,
    leakage: WindowLeakage | None,
    estimator: str | None,
) -> tuple[Responses, FloatArray | float]:
    """Return the responses of all methods, and their relative bias beside random error, (n_freq, n_frf).

    Parameters and errors as in `extract`.
    """
    responses = responses_of(frf, coherence, averages)
    if leakage is not None and len(responses.references) > 1:
        return responses, 0.0
    if leakage is not None:  # a scale common to all lines does not affect weights
        shares = leaked_force_noise(responses, leakage)
        return without_noise_bias(responses, shares, leakage.estimator)[0], 0.0
    # with several references the bias is not corrected, because noise of one force affects all FRFs
    kind = None if estimator is None or len(responses.references) > 1 else noise_bias_of(estimator)
    return without_noise_bias(responses, noise_to_signal(responses, kind), kind)
