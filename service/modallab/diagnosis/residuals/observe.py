"""What a fit sees of a measurement: its spectra with their random errors, and what is held out."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.comparable_lines import comparable_lines
from modallab.diagnosis.residuals.decorrelation import Decorrelation
from modallab.diagnosis.residuals.free_levels import FreeLevels
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.mains_lines import with_mains_errors
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.random_error import (
    check_random_error_known,
    coherence_and_variance,
    force_spectrum,
    incoherent_spectrum,
    replace_zeros,
    scale_error,
    scatter_error,
    shared_noise,
    weak_line_factor,
)
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
from modallab.diagnosis.residuals.source_power import shape_variance
from modallab.estimation.line_scatter import Estimate
from modallab.estimation.settings import FORCE_NOISE
from modallab.estimation.windows import WINDOWS
from modallab.rig.frf_channel import stands_for_response
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup


def _from_zero_frequency(measurement: Measurement) -> Measurement:
    """Return a measurement with an unusable line at 0 Hz, where it lacks that line of the analyser."""
    analyser, lowest = measurement.setup.analyser, measurement.frf.freq[0]
    if analyser.frequency_min > 0 or round(lowest / analyser.spacing) != 1:
        return measurement
    return measurement.by_line(lambda array: np.concatenate([np.zeros_like(array[:1]), array]))


def observe(measurement: Measurement, held_out: Sequence[FrfSelection], *, fraction: float) -> Observed:
    """Return the measured spectra, their random errors and the split into fitted and held-out data.

    Parameters
    ----------
    held_out
        FRFs excluded from every fit; with none, every 1/fraction-th line is held out instead.

    Raises
    ------
    InvalidInputError
        If no random error is known, see `check_random_error_known`; or if no line is left to fit.
    """
    check_random_error_known(measurement)
    spectra = ChannelSpectra.of(_from_zero_frequency(measurement.to(FrfKind.INERTANCE)))
    g2, coherence_variance = coherence_and_variance(spectra)
    noise_floor = measurement.noise_floor or 0.0
    analyser = measurement.setup.analyser
    # H1, whatever the estimator was: H2 = H1 / g2 and Hv = H1 / g.
    power = {"h1": 0.0, "h2": 1.0, "hv": 0.5}[analyser.estimator]
    h = spectra.h * g2**power
    prediction_error = RANDOM_ERROR.prediction_error
    scatter = None
    if spectra.coherence is None and spectra.noise_floor is None:
        scatter = scatter_error(spectra.h, analyser.window)
    line_error = _line_error(spectra, scatter)
    error = np.sqrt(coherence_variance + (line_error * weak_line_factor(h)) ** 2 + prediction_error**2)
    # Power has twice the relative error of amplitude.
    variance_floor = 4 * (noise_floor**2 + prediction_error**2)
    free_levels = FreeLevels.of(measurement.setup, simulated=measurement.route is not None)
    per_force = spectra.response is None and spectra.force is None
    incoherent = incoherent_variance = None
    if spectra.response is not None or _declares_coherence(measurement.setup, free_levels):
        incoherent, incoherent_variance = incoherent_spectrum(spectra, h, variance_floor)
    force, force_variance = force_spectrum(spectra, variance_floor)
    channels, lines = _held_out(spectra, held_out, fraction)
    compared = comparable_lines(analyser, spectra.freq, mean_kept=measurement.route is not None)
    usable = (g2 > FORCE_NOISE.min_coherence) & compared[:, None] & (np.abs(h) > 0)
    shape_variances: FloatArray | None = None
    if free_levels.shape and force is not None:
        shown = np.asarray(usable.reshape(*force.shape, -1).any(axis=2))
        shape_variances = np.broadcast_to(shape_variance(spectra.freq, force, shown), force.shape)
        force_variance = np.maximum(force_variance, shape_variances)
    window = WINDOWS[analyser.window].samples(RANDOM_ERROR.window_samples) ** 2
    observed = Observed(
        freq=spectra.freq,
        channels=spectra.channels,
        h=replace_zeros(h),
        error=error,
        coherence=g2,
        force=force,
        force_variance=force_variance,
        incoherent=incoherent,
        incoherent_variance=incoherent_variance,
        per_force=per_force,
        usable=usable,
        held_out=channels,
        held_out_lines=lines,
        correlation_length=float((window**2).mean() / window.mean() ** 2),
        bias=2 * coherence_variance**2 / error**2,
        averages=measurement.averages,
        scale_error=scale_error(measurement, scatter),
        variance_floor=variance_floor,
        shape_variance=shape_variances,
        shared_noise=shared_noise(spectra),
        response_once=_response_once(spectra),
        n_simultaneous=spectra.n_simultaneous,
        decorrelation=Decorrelation.of(spectra, coherence_variance / error**2),
        force_correlation=spectra.force_correlation,
        free_levels=free_levels,
    )
    if measurement.route is None:  # the rig here hums in responses alone
        observed = with_mains_errors(observed, analyser, spectra)
    _check_fittable(observed)
    return observed


def _declares_coherence(setup: RigSetup, levels: FreeLevels) -> bool:
    """Return whether a log book tells the coherence to expect where no response spectrum is known.

    Noise of unknown spectrum may lower it anyhow, and absolute noise by as much as the level has it.
    """
    return not levels.noise and not (levels.source and setup.noise.absolute)


def _line_error(spectra: ChannelSpectra, scatter: Sequence[Estimate] | None) -> FloatArray | float:
    """Return the random error of each FRF over its median, beside what coherence tells.

    As stated; without both, that which the scatter of neighbouring lines shows.
    """
    if spectra.noise_floor is not None:
        return spectra.noise_floor
    return 0.0 if scatter is None else np.array([estimate.value for estimate in scatter])


def _response_once(spectra: ChannelSpectra) -> BoolArray | None:
    """Return where the incoherent spectrum is that of no FRF before, (n_freq, n_out); None: everywhere."""
    if spectra.n_simultaneous == 1:
        return None
    return np.repeat(stands_for_response(spectra.channels)[None], len(spectra.freq), axis=0)


def _held_out(
    spectra: ChannelSpectra, held_out: Sequence[FrfSelection], fraction: float
) -> tuple[BoolArray, BoolArray]:
    """Return the held-out FRFs (n_out,) and lines (n_freq,)."""
    channels = np.array(
        [any(selection.selects(channel) for selection in held_out) for channel in spectra.channels]
    )
    lines = np.zeros(len(spectra.freq), bool)
    if not channels.any() and fraction > 0:
        lines[2 :: max(2, round(1 / fraction))] = True
    return channels, lines


def _check_fittable(observed: Observed) -> None:
    if not observed.usable.any():
        raise InvalidInputError(
            "no line shows a response",
            field="coherence",
            value=float(observed.coherence.max()),
            allowed=bounds(exclusive_minimum=FORCE_NOISE.min_coherence),
        )
    if not observed.fitted.any():
        pairs = zip(observed.outputs, observed.held_out, strict=True)
        responses = list(dict.fromkeys(str(dof) for dof, out in pairs if out))
        raise InvalidInputError(
            "with these held out nothing is left to fit", field="hold_out", value=list(responses)
        )
