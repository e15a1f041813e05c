"""Inverse eigensensitivity from complex modes: mass, stiffness and damping, located first."""

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.fe.structure import Structure
from modallab.updating.method import MASS_STIFFNESS_AND_DAMPING, UPDATERS, UpdateResult, UpdatingMethod
from modallab.updating.options import ComplexTwoStageOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.target import complex_modes
from modallab.updating.two_stage import update_in_two_stages

DEFAULTS = ComplexTwoStageOptions()


def complex_inverse_eigensensitivity(
    structure: Structure,
    parameterisation: Parameterisation,
    target: ModalModel,
    *,
    options: ComplexTwoStageOptions = DEFAULTS,
    progress: Progress = silent,
) -> UpdateResult:
    """Correct mass, stiffness and damping of elements from measured complex modes, located first.

    The stages of `inverse_eigensensitivity`, with K + iD in place of K and complex eigenvalues and
    shapes. Coefficients are real: real and imaginary parts are equations of their own, instead of a
    complex solution whose imaginary part of a mass is left over. A coefficient of damping is the loss
    factor that is added to an element's own, D_e = eta K_e with K_e as corrected; the model may be
    undamped. 1992 thesis, chapter 6.

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
        If there are fewer measured numbers than coefficients, or a measured mode pairs with none of
        the model where a stage starts.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    return update_in_two_stages(structure, parameterisation, complex_modes(target), options, progress)


UPDATERS.register("complex_inverse_eigensensitivity")(
    UpdatingMethod(complex_inverse_eigensensitivity, ComplexTwoStageOptions, parts=MASS_STIFFNESS_AND_DAMPING)
)
