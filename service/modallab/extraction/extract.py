"""Extraction of a modal model from measured FRFs."""

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Protocol

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet
from modallab.core.line_options import Band, line_mask
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, part, silent
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.extraction.averaging.damping_model import (
    select_damping_model,
    with_contradiction_flags,
    with_damping_model,
)
from modallab.extraction.default_method import MethodChoice, default_method
from modallab.extraction.method_options import options_for, options_type
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.multi_mode_extraction import extract_globally
from modallab.extraction.options import Damping, ExtractionOptions
from modallab.extraction.preprocessing.leakage import WindowLeakage, noise_bias_of
from modallab.extraction.preprocessing.line_noise import has_coherence
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
    """Extraction of a modal model with given options."""

    def __call__(self, *, options: ExtractionOptions, progress: Progress) -> ModalModel:
        """Return the modal model."""
        ...


def extract(
    frf: FrfSet,
    *,
    coherence: FloatArray | None,
    averages: float,
    method: str | None = None,
    options: ExtractionOptions | None = None,
    bands: Sequence[tuple[float, float]] | None = None,
    n_modes: int | None = None,
    leakage: WindowLeakage | None = None,
    estimator: str | None = None,
    correlation: ErrorCorrelation | None = None,
    exclude: Sequence[Band] = (),
    progress: Progress = silent,
) -> ModalModel:
    """Return the modal model of a set of frequency response functions (FRFs).

    Parameters
    ----------
    frf
        Receptance, mobility or inertance, from one drive point or several, or from a roving drive point to
        one response or several.
    coherence
        (n_freq, n_out), the multiple coherence if several forces act simultaneously, or
        (n_freq, n_out, n_in); None if not measured: the misfit of the fits then replaces the random error.
    averages
        Effective number of averages of the coherence.
    method
        Name in `EXTRACTION_METHODS` (single-mode methods, applied to every FRF) or in `GLOBAL_METHODS` (all
        modes and FRFs together); None chooses one by the number of references, as `default_method`.
    options
        Options of the method, or those common to several methods; None chooses all from the data.
    bands
        Pairs (lower, upper), Hz, with one mode each, for a global method one or more; None finds them from
        the FRFs.
    n_modes
        Number of modes to keep, the most prominent ones; None keeps all.
    leakage
        Window of the random records and estimator; None for records without leakage, periodic or transient
        within the window.
    estimator
        "h1", "h2" or "hv", for the correction of its bias by noise; None if unknown.
    correlation
        Correlation of the random errors of lines by the window of records without leakage; None: lines are
        independent.
    exclude
        Pairs (lower, upper), Hz, whose lines are left out.
    progress
        Receives the progress, 0 to 1, with a text.

    Returns
    -------
    ModalModel
        Modes with standard errors, flags, choices and notes.

    Raises
    ------
    NoModeInBandError
        If a requested band contains no mode, or no mode is found.
    InvalidInputError
        If the inputs are inconsistent.
    """
    if n_modes is not None and n_modes < 1:
        raise InvalidInputError("at least one mode", field="n_modes", value=n_modes, allowed=bounds(1))
    if method is not None:
        options_type(method)  # a name that does not exist is refused before any work
    lines = line_mask(frf.freq, exclude=exclude)
    if lines is not None:
        frf, coherence = frf.at(lines), None if coherence is None else coherence[lines]
    responses, bias = responses_read(frf, coherence, averages, leakage=leakage, estimator=estimator)
    if leakage is None:
        responses = replace(responses, correlation=correlation)
    choice = _method_choice(method, responses, options)
    requested = options_for(choice.method, options)
    read = _reader(choice.method, responses, bias, bands=bands, n_modes=n_modes, leakage=leakage)
    model = _with_damping_of(read, choice.method, requested, progress)
    warned = (*low_coherence_notes(model, responses), *white_forces_notes(responses, leakage))
    return replace(
        model,
        notes=(*model.notes, *warned),
        choices={"method": choice.reason, **model.choices},
        options=asdict(requested),
        exclude=tuple((lower, upper) for lower, upper in exclude),
    )


def _reader(
    method: str,
    responses: Responses,
    bias: FloatArray | float,
    *,
    bands: Sequence[tuple[float, float]] | None,
    n_modes: int | None,
    leakage: WindowLeakage | None,
) -> Read:
    """Return the extraction from some responses by a method."""
    if method in GLOBAL_METHODS:
        return partial(
            extract_globally,
            GLOBAL_METHODS[method].find,
            responses,
            method=method,
            bands=bands,
            n_modes=n_modes,
            leakage=leakage,
            bias=bias,
            known={},
        )
    return partial(
        extract_mode_by_mode,
        EXTRACTION_METHODS[method],
        responses,
        method=method,
        bands=bands,
        n_modes=n_modes,
        leakage=leakage,
    )


def _method_choice(
    method: str | None, responses: Responses, options: ExtractionOptions | None
) -> MethodChoice:
    """Return the requested method, or by default the one for the number of references."""
    if method is None:
        return default_method(len(responses.references), options)
    return MethodChoice(method, f"{method}: as requested")


def _with_damping_of(read: Read, method: str, options: ExtractionOptions, progress: Progress) -> ModalModel:
    """Return the modal model with the requested damping model, or the one that the data indicate."""
    exact = method in GLOBAL_METHODS or EXTRACTION_METHODS[method].exact
    if options.damping is None and exact:
        return _by_identified_damping_model(read, options, progress)
    model = read(options=options, progress=progress)
    return with_contradiction_flags(model, options.assumed_damping) if exact else model


def _by_identified_damping_model(read: Read, options: ExtractionOptions, progress: Progress) -> ModalModel:
    """Return the modal model with the damping model indicated by the data, structural if undecided."""
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
    """Return the responses with noise bias corrected, and the remaining relative bias, (n_freq, n_frf).

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
    noise = noise_to_signal(responses, kind)
    responses, bias = without_noise_bias(responses, noise, kind)
    return replace(responses, noise=noise if has_coherence(responses) else None), bias
