"""FRFs put together again from modes, and how much of the measured ones they leave."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.averaging.out_of_band_residuals import fit_out_of_band, out_of_band_columns
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.line_noise import has_coherence
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS
from modallab.extraction.single_mode.plan import choice_value

APART = 0.01  # relative error granted to the modes: residuals shall not mend what they lack at resonance
NOTED = 0.1  # of an FRF: less is left by the random error and leakage of ordinary tests
CLEAR = 3.0  # times the random error


def resynthesise(
    model: ModalModel, freq: FloatArray, kind: FrfKind = FrfKind.RECEPTANCE, *, drive: Dof | None = None
) -> FrfSet:
    """Return the FRFs that modes and residuals make, (n_freq, n_dof, n_ref); n_ref is 1 with `drive` given.

    `H_j = sum_r A_rj/(lambda_r - omega^2) + R_j - L_j/omega^2`, with the modal constants of each FRF and
    what lies above and below the range, near it poles as in it; of viscously damped modes pole and mirror
    image. Where frequencies wander, the pole of each FRF is its own: the FRFs are then of as many
    structures, and no common pole fits them. From another drive point, and where a model has no FRFs,
    `A_rjk = phi_rj phi_rk` with the common poles and no residuals.

    Parameters
    ----------
    model
        Modes read from FRFs, or mass-normalised ones.
    freq
        (n_freq,) Hz.
    kind
        What to return: m/N or its derivatives.
    drive
        Where the force acts; those of the model's FRFs by default.

    Raises
    ------
    InvalidInputError
        If the model has neither FRFs nor a mass-normalised shape at the drive point, or if 0 Hz is asked of
        a free structure's receptance or mobility.
    """
    own = bool(model.references) and model.modal_constant is not None
    if own and (drive is None or drive == model.drive):
        constant, forces = _constants(model), model.references
        pole, beyond = _poles(model), _beyond(model, freq)
        residuals = np.zeros((2, len(model.frfs))) if model.residuals is None else model.residuals
    else:
        force = _driven(model, drive if drive is not None else model.drive)
        constant, forces = _products(model, force), (force,)
        pole = np.repeat(_common(model)[:, None], len(model.dofs), axis=1)
        residuals, beyond = np.zeros((2, len(model.dofs))), 0.0
    steps = FrfKind.RECEPTANCE.steps_to(kind)
    factor = ((2j * np.pi * freq) ** steps)[:, None]
    receptance = _modes(model, freq, pole, constant) + residuals[1] + beyond
    values = factor * receptance + _below(freq, steps, residuals[0])
    return FrfSet(freq, values.reshape(len(freq), -1, len(forces)), model.dofs, forces, kind)


def with_resynthesis(
    model: ModalModel,
    responses: Responses,
    bands: Sequence[Band],
    *,
    smeared: int = 0,
    beyond: ComplexArray | None = None,
) -> ModalModel:
    """Return modes with residuals of every FRF, and the part of it that all this leaves.

    The residuals are fitted by weighted linear least squares to what the modes leave inside the bands.
    The error is the rms of the rest over the rms of the FRF, both as mobility, in which resonances of
    like damping are alike high; random error of the measurement is in it. An FRF of zeros has the error 0.

    Parameters
    ----------
    model
        From these responses by a single-mode method.
    bands
        Where its modes were looked for.
    smeared
        Lines to either side of a resonance's half-power points that a window holds down: modes do not
        resynthesise these, and they are left out.
    beyond
        (n_beyond,) (rad/s)^2, poles near the bands that bend the FRFs in them, in any law of damping.
    """
    lines = np.zeros(len(responses.freq), bool)
    for band in bands:
        lines[band.first : band.last + 1] = True
    if smeared:
        lines &= ~_near(model, responses.freq, smeared)
    freq, measured, variance = responses.freq[lines], responses.receptance[lines], responses.variance[lines]
    modes = _modes(model, freq, _poles(model), _constants(model))
    usable = np.isfinite(variance)
    error = np.where(usable, variance, 0.0) + (APART * np.abs(modes)) ** 2
    error = np.where(usable & (error > 0), error, np.inf)
    poles = np.zeros(0, complex) if beyond is None else beyond
    residuals = fit_out_of_band(freq, measured - modes, error, poles)
    rest = measured - modes - out_of_band_columns(freq, poles) @ residuals
    misfit = relative_error(freq, rest, measured, usable)
    random = relative_error(freq, np.sqrt(np.where(usable, variance, 0.0)), measured, usable)
    return replace(
        model,
        residuals=residuals[:2],
        beyond_eigenvalue=beyond,
        beyond_constant=None if beyond is None else residuals[2:],
        resynthesis_error=misfit,
        notes=(*model.notes, *_left(misfit, random, model.frfs, told=has_coherence(responses))),
    )


def _near(model: ModalModel, freq: FloatArray, smeared: int) -> BoolArray:
    """Return the lines near a resonance, (n_freq,)."""
    half = np.abs(model.loss_factors) * model.frequencies / 2 + smeared * np.median(np.diff(freq))
    return np.asarray((np.abs(freq[:, None] - model.frequencies) <= half).any(axis=1))


def relative_error(
    freq: FloatArray,
    rest: ComplexArray | FloatArray,
    measured: ComplexArray,
    usable: BoolArray,
) -> FloatArray:
    """Return the rms of what is left over the rms of each FRF, (n_frf,), both as mobility; 0 for zeros.

    Parameters
    ----------
    freq
        (n_freq,) Hz.
    rest, measured
        (n_freq, n_frf) m/N.
    usable
        (n_freq, n_frf) lines that count.
    """

    def power(values: ComplexArray | FloatArray) -> FloatArray:
        # largest first: squares of receptances are small numbers
        return np.asarray((usable * (freq[:, None] * np.abs(values) / size) ** 2).sum(axis=0))

    size = np.maximum((np.abs(measured) * freq[:, None]).max(initial=0.0), 1e-300)
    whole = power(measured)
    return np.asarray(np.sqrt(power(rest) / np.where(whole > 0, whole, 1.0)) * (whole > 0))


def _modes(model: ModalModel, freq: FloatArray, pole: ComplexArray, constant: ComplexArray) -> ComplexArray:
    """Return the receptance of all modes, (n_freq, n_frf); pole and constant (n_modes, n_frf)."""
    law = DAMPING_MODELS[Damping(choice_value(model.choices, "damping") or Damping.STRUCTURAL)]
    values = np.zeros((len(freq), constant.shape[1]), complex)
    for one, size in zip(pole, constant, strict=True):  # one at a time: together they may not fit into memory
        values += law.response(freq[:, None], one, size)
    return values


def _beyond(model: ModalModel, freq: FloatArray) -> ComplexArray | float:
    """Return the receptance of poles beyond the range, (n_freq, n_frf), 0 if none is known."""
    if model.beyond_eigenvalue is None or model.beyond_constant is None:
        return 0.0
    return out_of_band_columns(freq, model.beyond_eigenvalue)[:, 2:] @ model.beyond_constant


def _constants(model: ModalModel) -> ComplexArray:
    assert model.modal_constant is not None
    return model.modal_constant


def _common(model: ModalModel) -> ComplexArray:
    return np.array([mode.eigenvalue for mode in model.modes], np.complex128)


def _poles(model: ModalModel) -> ComplexArray:
    """Return the eigenvalue of every mode in every FRF, (n_modes, n_frf)."""
    common = np.repeat(_common(model)[:, None], len(model.frfs), axis=1)
    frequency, loss_factor = model.fitted_frequency, model.fitted_loss_factor
    if model.wander is None or frequency is None or loss_factor is None:
        return common
    own = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
    return np.where(np.isfinite(model.wander.shift), own, common)


def _products(model: ModalModel, drive: Dof) -> ComplexArray:
    at = next(i for i, dof in enumerate(model.dofs) if dof.point == drive.point)
    sense = model.dofs[at].sign * drive.sign
    return np.asarray(sense * model.shapes[at][:, None] * model.shapes.T)


def _driven(model: ModalModel, drive: Dof | None) -> Dof:
    """Return the drive point, if shapes tell what a force there does."""
    there = drive is not None and any(dof.point == drive.point for dof in model.dofs)
    if drive is None or not there or model.normalisation != "mass":
        raise InvalidInputError(
            "FRFs need mass-normalised modes with a shape at the drive point",
            field="drive",
            value="none" if drive is None else str(drive),
            allowed=", ".join(str(dof) for dof in model.dofs[:5]) if model.normalisation == "mass" else "",
        )
    return drive


def _below(freq: FloatArray, steps: int, mass: ComplexArray) -> ComplexArray:
    """Return `-L/omega^2` derived `steps` times, (n_freq, n_frf)."""
    if steps == 2:
        return np.broadcast_to(mass, (len(freq), len(mass)))
    if not mass.any():
        return np.zeros((len(freq), len(mass)), complex)
    if (freq == 0).any():
        raise InvalidInputError(
            "what moves as a rigid body has inertance alone at 0 Hz", field="freq", value=0.0, allowed="> 0"
        )
    omega = 2 * np.pi * freq
    return np.asarray(((1j * omega) ** steps / -(omega**2))[:, None] * mass)


def _left(misfit: FloatArray, random: FloatArray, names: Sequence[str], *, told: bool) -> Sequence[str]:
    """Return a note where modes and residuals leave more of FRFs than random error can, if that is told."""
    poor = np.flatnonzero((misfit > NOTED) & (misfit > CLEAR * random))
    if not len(poor):
        return ()
    worst = int(poor[np.argmax(misfit[poor])])
    chance = "no coherence tells how much of it is random error"
    if told:
        chance = f"of which random error is {100 * random[worst]:.1g} %"
    return (
        f"modes and residuals leave more than {100 * NOTED:.0f} % of {len(poor)} FRFs, most of "
        f"{names[worst]}: {100 * misfit[worst]:.0f} %, {chance}",
    )
