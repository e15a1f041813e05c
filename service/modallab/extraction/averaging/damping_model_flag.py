"""What the law of damping costs where nobody has said which one holds."""

from dataclasses import replace

from modallab.core.modal_model import ModalModel, Mode
from modallab.extraction.options import Damping, ExtractionOptions
from modallab.extraction.preprocessing.line_noise import has_coherence
from modallab.extraction.preprocessing.responses import Responses

PART = 1 / 3  # of a standard error: intervals that leave out so much still hold 94 % instead of 95 %


def with_damping_model_flags(
    model: ModalModel, responses: Responses, options: ExtractionOptions
) -> ModalModel:
    """Return the modes, flagged where their frequency would be another under viscous damping.

    A viscous mode is a pole at `omega_r sqrt(1 - zeta^2)`, which structural modes are fitted to with complex
    constants as well as viscous ones with real: lines do not tell the laws apart where damping is light,
    and frequencies differ by `eta^2/4` of themselves, `eta = 2 zeta`. That is no random error. Said where
    coherence tells how large this is, unless the viscous law was asked for or told.

    Parameters
    ----------
    model
        Fitted under the law of `options`.
    """
    if options.law is Damping.VISCOUS or not has_coherence(responses):
        return model
    return replace(model, modes=tuple(_flagged(mode) for mode in model.modes))


def _flagged(mode: Mode) -> Mode:
    higher = mode.loss_factor**2 / 4 * mode.frequency
    if higher <= PART * mode.standard_errors["frequency"]:
        return mode
    flag = f"damping_law: frequency {higher:.2g} Hz higher if damping is viscous"
    return replace(mode, flags=(*mode.flags, flag))
