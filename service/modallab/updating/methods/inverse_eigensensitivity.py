"""Inverse eigensensitivity in two stages: macro elements first, then the elements inside them."""

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.fe.structure import Structure
from modallab.updating.method import UPDATERS, UpdateResult, UpdatingMethod
from modallab.updating.options import TwoStageOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.target import real_modes
from modallab.updating.two_stage import update_in_two_stages

DEFAULTS = TwoStageOptions()


def inverse_eigensensitivity(
    structure: Structure,
    parameterisation: Parameterisation,
    target: ModalModel,
    *,
    options: TwoStageOptions = DEFAULTS,
    progress: Progress = silent,
) -> UpdateResult:
    """Correct mass and stiffness of elements from measured frequencies and shapes, located first.

    Stage one moves the coefficients of the macro elements until they stand still; those that end
    away from 1 are suspected. Stage two moves the elements inside them from where stage one ended,
    all others back at 1. Works at the measured DoFs and modes alone, without expansion; the model
    is held undamped against the real part of measured shapes. 1992 thesis, chapter 3.

    Parameters
    ----------
    target
        Measured modes; shapes that are not mass-normalised count up to their scale.

    Raises
    ------
    UnderdeterminedError
        If there are fewer measured numbers than coefficients, or a measured mode pairs with none of
        the model where a stage starts.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    return update_in_two_stages(structure, parameterisation, real_modes(target), options, progress)


UPDATERS.register("inverse_eigensensitivity")(UpdatingMethod(inverse_eigensensitivity, TwoStageOptions))
