"""All coefficients at once, without a location stage, as far from no change as the data ask for."""

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.fe.structure import Structure
from modallab.updating.method import UPDATERS, UpdateResult, UpdatingMethod
from modallab.updating.one_stage import update_in_one_stage
from modallab.updating.options import OneStageOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.target import real_modes

DEFAULTS = OneStageOptions()


def one_shot(
    structure: Structure,
    parameterisation: Parameterisation,
    target: ModalModel,
    *,
    options: OneStageOptions = DEFAULTS,
    progress: Progress = silent,
) -> UpdateResult:
    """Correct mass and stiffness of all elements at once, with a prior as wide as the data ask for.

    Weighted least squares in the logarithms of the coefficients: rows count by their stated errors,
    each coefficient by a prior whose width is the one of most evidence. With the sparse prior those
    that need not move stay at 1, so that no stage has to say first where the errors are. Intervals of
    95 % are those of the data alone. Works at the measured DoFs and modes, without expansion, and
    pairs modes again at every step.

    Parameters
    ----------
    target
        Measured modes; shapes that are not mass-normalised count up to their scale.

    Raises
    ------
    UnderdeterminedError
        If there are fewer measured numbers than coefficients and the options refuse these, no
        measured number moves with any coefficient, or a measured mode pairs with none of the model
        at the start and at the end.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    return update_in_one_stage(structure, parameterisation, real_modes(target), options, progress)


UPDATERS.register("one_shot")(UpdatingMethod(one_shot, OneStageOptions))
