"""Flags on frequencies that depend on the damping model, where it is not known."""

from dataclasses import replace

from modallab.core.modal_model import ModalModel, Mode
from modallab.extraction.averaging.settings import DAMPING_MODEL
from modallab.extraction.options import Damping, ExtractionOptions
from modallab.extraction.preprocessing.line_noise import has_coherence
from modallab.extraction.preprocessing.responses import Responses


def with_damping_model_flags(
    model: ModalModel, responses: Responses, options: ExtractionOptions
) -> ModalModel:
    """Return the modes, flagged where their frequency would differ under viscous damping.

    A viscous mode has its pole at `omega_r sqrt(1 - zeta^2)`. Structural modes with complex constants fit it
    as well as viscous modes with real ones: for light damping the lines do not decide between the models,
    whose frequencies differ by the part `eta^2/4`, `eta = 2 zeta`. That is not a random error. The flag is
    set where coherence gives the random error, unless the viscous model was requested or identified.

    Parameters
    ----------
    model
        Fitted with the damping model of `options`.
    responses
        FRFs of the fit.
    options
        Of the extraction.
    """
    if options.assumed_damping is Damping.VISCOUS or not has_coherence(responses):
        return model
    return replace(model, modes=tuple(_flagged(mode) for mode in model.modes))


def _flagged(mode: Mode) -> Mode:
    higher = mode.loss_factor**2 / 4 * mode.frequency
    if higher <= DAMPING_MODEL.flagged_fraction * mode.standard_errors["frequency"]:
        return mode
    flag = f"damping_law: frequency {higher:.2g} Hz higher if damping is viscous"
    return replace(mode, flags=(*mode.flags, flag))
