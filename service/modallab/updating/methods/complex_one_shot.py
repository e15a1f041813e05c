"""All coefficients at once from complex modes: mass, stiffness and damping, without a location stage."""

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.fe.structure import Structure
from modallab.updating.method import MASS_STIFFNESS_AND_DAMPING, UPDATERS, UpdateResult, UpdatingMethod
from modallab.updating.one_stage import update_in_one_stage
from modallab.updating.options import OneStageOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.target import complex_modes

DEFAULTS = OneStageOptions()


def complex_one_shot(
    structure: Structure,
    parameterisation: Parameterisation,
    target: ModalModel,
    *,
    options: OneStageOptions = DEFAULTS,
    progress: Progress = silent,
) -> UpdateResult:
    """Correct mass, stiffness and damping of all elements at once from measured complex modes.

    The prior, weights and steps of `one_shot`, with the rows and coefficients of
    `complex_inverse_eigensensitivity`: real and imaginary parts are equations of their own, and a
    coefficient of damping is the loss factor that is added to an element's own.

    Parameters
    ----------
    target
        Measured modes of a hysteretically damped structure; shapes that are not mass-normalised count
        up to a complex scale.

    Raises
    ------
    InvalidInputError
        If the modes are real, or the model's own damping is not hysteretic.
    UnderdeterminedError
        As `one_shot`.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    return update_in_one_stage(structure, parameterisation, complex_modes(target), options, progress)


UPDATERS.register("complex_one_shot")(
    UpdatingMethod(complex_one_shot, OneStageOptions, parts=MASS_STIFFNESS_AND_DAMPING)
)
