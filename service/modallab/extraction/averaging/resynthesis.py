"""Synthesis of FRFs from modes and residuals, and their misfit to measured FRFs."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.averaging.out_of_band_residuals import fit_out_of_band, out_of_band_columns
from modallab.extraction.averaging.settings import RESYNTHESIS
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.line_noise import has_coherence, line_weights
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS
from modallab.extraction.single_mode.plan import choice_value

MISFIT_NOTE = "modes and residuals leave"


def resynthesise(
    model: ModalModel, freq: FloatArray, kind: FrfKind = FrfKind.RECEPTANCE, *, drive: Dof | None = None
) -> FrfSet:
    """Return the FRFs of modes and residuals, (n_freq, n_dof, n_ref); n_ref is 1 with `drive` given.

    `H_j = sum_r A_rj/(lambda_r - omega^2) + R_j - L_j/omega^2`, with the modal constants of each FRF,
    residuals of modes above and below the range, and poles near its ends; viscously damped modes have a pole
    and its mirror image. Where frequencies are inconsistent, each FRF has its own poles: the FRFs then belong
    to different structures without common poles. For another drive point, and for a model without FRFs,
    `A_rjk = phi_rj phi_rk` with the common poles and without residuals.

    Parameters
    ----------
    model
        Modes identified from FRFs, or mass-normalised modes.
    freq
        (n_freq,) Hz.
    kind
        Kind of FRF: m/N or its derivatives.
    drive
        Drive point; those of the model's FRFs by default.

    Raises
    ------
    InvalidInputError
        If the model has neither FRFs nor a mass-normalised shape at the drive point, or if receptance or
        mobility of a free structure is requested at 0 Hz.
    """
    measured_frfs = bool(model.references) and model.modal_constant is not None
    if measured_frfs and (drive is None or drive == model.drive):
        constant, forces = _constants(model), model.references
        pole, out_of_band = _poles(model), _out_of_band(model, freq)
        residuals = np.zeros((2, len(model.frfs))) if model.residuals is None else model.residuals
    else:
        force = _drive_point(model, drive if drive is not None else model.drive)
        constant, forces = _products(model, force), (force,)
        pole = np.repeat(_common(model)[:, None], len(model.dofs), axis=1)
        residuals, out_of_band = np.zeros((2, len(model.dofs))), 0.0
    steps = FrfKind.RECEPTANCE.steps_to(kind)
    factor = ((2j * np.pi * freq) ** steps)[:, None]
    receptance = _modes(model, freq, pole, constant) + residuals[1] + out_of_band
    values = factor * receptance + _rigid_body_terms(freq, steps, residuals[0])
    return FrfSet(freq, values.reshape(len(freq), -1, len(forces)), model.dofs, forces, kind)


def with_resynthesis(
    model: ModalModel,
    responses: Responses,
    bands: Sequence[Band],
    *,
    smeared: int = 0,
    out_of_band_poles: ComplexArray | None = None,
) -> ModalModel:
    """Return the modes with residuals of every FRF and the relative misfit.

    Residuals are fitted by weighted linear least squares to the FRFs without modes inside the bands. The
    misfit is the root mean square of the remainder over that of the FRF, both as mobility, in which
    resonances of equal damping have similar heights; it includes the random error. An FRF of zeros has a
    misfit of 0.

    Parameters
    ----------
    model
        From these responses by a single-mode method.
    responses
        Measured FRFs.
    bands
        Bands of the modes.
    smeared
        Lines beyond the half-power points of a resonance that leakage distorts: they are left out.
    out_of_band_poles
        (n_poles,) (rad/s)^2, poles near the bands that bend the FRFs inside, in the damping model of the fit.
    """
    lines = np.zeros(len(responses.freq), bool)
    for band in bands:
        lines[band.first : band.last + 1] = True
    if smeared:
        lines &= ~_near(model, responses.freq, smeared)
    freq, measured, variance = responses.freq[lines], responses.receptance[lines], responses.variance[lines]
    modes = _modes(model, freq, _poles(model), _constants(model))
    usable = np.isfinite(variance)
    error = np.where(usable, variance, 0.0) + (RESYNTHESIS.modal_error * np.abs(modes)) ** 2
    error = np.where(usable & (error > 0), error, np.inf)
    poles = np.zeros(0, complex) if out_of_band_poles is None else out_of_band_poles
    residuals = fit_out_of_band(freq, measured - modes, error, poles)
    remainder = measured - modes - out_of_band_columns(freq, poles) @ residuals
    misfit = relative_error(freq, remainder, measured, usable)
    known = has_coherence(responses)
    if not known:  # then the scatter of neighbouring lines tells it
        variance = 1 / np.maximum(line_weights(responses)[lines], SAFE_DIVISOR)
    random = relative_error(freq, np.sqrt(np.where(usable, variance, 0.0)), measured, usable)
    return replace(
        model,
        residuals=residuals[:2],
        out_of_band_eigenvalue=out_of_band_poles,
        out_of_band_constant=None if out_of_band_poles is None else residuals[2:],
        resynthesis_error=misfit,
        ranges=_ranges(responses.freq, bands),
        notes=(*model.notes, *_misfit_notes(misfit, random, model.frfs, has_error=known)),
    )


def _ranges(freq: FloatArray, bands: Sequence[Band]) -> tuple[tuple[float, float], ...]:
    """Return first and last line, Hz, of each run of adjacent bands."""
    runs: list[list[int]] = []
    for first, last in sorted((band.first, band.last) for band in bands):
        if runs and first <= runs[-1][1] + 1:
            runs[-1][1] = max(runs[-1][1], last)
        else:
            runs.append([first, last])
    return tuple((float(freq[first]), float(freq[last])) for first, last in runs)


def _near(model: ModalModel, freq: FloatArray, smeared: int) -> BoolArray:
    """Return which lines are near a resonance, (n_freq,) boolean."""
    half = np.abs(model.loss_factors) * model.frequencies / 2 + smeared * np.median(np.diff(freq))
    return np.asarray((np.abs(freq[:, None] - model.frequencies) <= half).any(axis=1))


def relative_error(
    freq: FloatArray,
    remainder: ComplexArray | FloatArray,
    measured: ComplexArray,
    usable: BoolArray,
) -> FloatArray:
    """Return the root mean square of a remainder over that of each FRF, (n_frf,), as mobility; 0 for zeros.

    Parameters
    ----------
    freq
        (n_freq,) Hz.
    remainder, measured
        (n_freq, n_frf) m/N.
    usable
        (n_freq, n_frf) lines that count.
    """

    def power(values: ComplexArray | FloatArray) -> FloatArray:
        # normalised before squaring: squares of receptances are small numbers
        return np.asarray((usable * (freq[:, None] * np.abs(values) / size) ** 2).sum(axis=0))

    size = np.maximum((np.abs(measured) * freq[:, None]).max(initial=0.0), SAFE_DIVISOR)
    measured_power = power(measured)
    return np.asarray(
        np.sqrt(power(remainder) / np.where(measured_power > 0, measured_power, 1.0)) * (measured_power > 0)
    )


def _modes(model: ModalModel, freq: FloatArray, pole: ComplexArray, constant: ComplexArray) -> ComplexArray:
    """Return the receptance of all modes, (n_freq, n_frf); pole and constant (n_modes, n_frf)."""
    law = DAMPING_MODELS[Damping(choice_value(model.choices, "damping") or Damping.STRUCTURAL)]
    values = np.zeros((len(freq), constant.shape[1]), complex)
    for eigenvalue, size in zip(
        pole, constant, strict=True
    ):  # one at a time: together they may not fit into memory
        values += law.response(freq[:, None], eigenvalue, size)
    return values


def _out_of_band(model: ModalModel, freq: FloatArray) -> ComplexArray | float:
    """Return the receptance of poles outside the range, (n_freq, n_frf), 0 if there are none."""
    if model.out_of_band_eigenvalue is None or model.out_of_band_constant is None:
        return 0.0
    return out_of_band_columns(freq, model.out_of_band_eigenvalue)[:, 2:] @ model.out_of_band_constant


def _constants(model: ModalModel) -> ComplexArray:
    assert model.modal_constant is not None
    return model.modal_constant


def _common(model: ModalModel) -> ComplexArray:
    return np.array([mode.eigenvalue for mode in model.modes], np.complex128)


def _poles(model: ModalModel) -> ComplexArray:
    """Return the eigenvalue of every mode in every FRF, (n_modes, n_frf)."""
    common = np.repeat(_common(model)[:, None], len(model.frfs), axis=1)
    frequency, loss_factor = model.fitted_frequency, model.fitted_loss_factor
    if model.frequency_inconsistency is None or frequency is None or loss_factor is None:
        return common
    fitted = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
    return np.where(np.isfinite(model.frequency_inconsistency.shift), fitted, common)


def _products(model: ModalModel, drive: Dof) -> ComplexArray:
    at = next(i for i, dof in enumerate(model.dofs) if dof.point == drive.point)
    sense = model.dofs[at].sign * drive.sign
    return np.asarray(sense * model.shapes[at][:, None] * model.shapes.T)


def _drive_point(model: ModalModel, drive: Dof | None) -> Dof:
    """Return the drive point if the model has mass-normalised shapes there."""
    has_shape = drive is not None and any(dof.point == drive.point for dof in model.dofs)
    if drive is None or not has_shape or model.normalisation != "mass":
        raise InvalidInputError(
            "FRFs require mass-normalised modes with a shape at the drive point",
            field="drive",
            value=None if drive is None else str(drive),
            allowed=[str(dof) for dof in model.dofs[:5]] if model.normalisation == "mass" else [],
        )
    return drive


def _rigid_body_terms(freq: FloatArray, steps: int, mass: ComplexArray) -> ComplexArray:
    """Return `-L/omega^2` differentiated `steps` times, (n_freq, n_frf)."""
    if steps == 2:
        return np.broadcast_to(mass, (len(freq), len(mass)))
    if not mass.any():
        return np.zeros((len(freq), len(mass)), complex)
    if (freq == 0).any():
        raise InvalidInputError(
            "what moves as a rigid body has inertance alone at 0 Hz",
            field="freq",
            value=0.0,
            allowed=bounds(exclusive_minimum=0, unit="Hz"),
        )
    omega = 2 * np.pi * freq
    return np.asarray(((1j * omega) ** steps / -(omega**2))[:, None] * mass)


def _misfit_notes(
    misfit: FloatArray, random: FloatArray, names: Sequence[str], *, has_error: bool
) -> Sequence[str]:
    """Return a note on FRFs whose misfit exceeds the random error, as far as that is known."""
    poor = np.flatnonzero(
        (misfit > RESYNTHESIS.largest_misfit) & (misfit > RESYNTHESIS.misfit_errors * random)
    )
    if not len(poor):
        return ()
    worst = int(poor[np.argmax(misfit[poor])])
    chance = f"random error {100 * random[worst]:.2g} %"
    if not has_error:
        chance += " by the scatter of neighbouring lines"
    return (
        f"{MISFIT_NOTE} more than {100 * RESYNTHESIS.largest_misfit:.0f} % of {len(poor)} FRFs "
        f"unexplained, most at {names[worst]}: {100 * misfit[worst]:.0f} %, {chance}",
    )
