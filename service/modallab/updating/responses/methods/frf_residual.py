"""All coefficients at once from measured frequency responses, line by line, without modes between."""

from modallab.core.progress import Progress, silent
from modallab.fe.structure import Structure
from modallab.updating.method import MASS_STIFFNESS_AND_DAMPING, UpdateResult, UpdatingMethod
from modallab.updating.options import ResponseUpdateOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.responses.method import RESPONSE_UPDATERS
from modallab.updating.responses.run import update_on_responses
from modallab.updating.responses.target import TargetResponses

DEFAULTS = ResponseUpdateOptions()


def frf_residual(
    structure: Structure,
    parameterisation: Parameterisation,
    target: TargetResponses,
    *,
    options: ResponseUpdateOptions = DEFAULTS,
    progress: Progress = silent,
) -> UpdateResult:
    """Correct mass, stiffness and damping of all elements at once on measured frequency responses.

    Rows are ln(H_measured / H_model) over its random error, whose derivatives are exact; prior and steps are
    those of `one_shot`. In the first steps an assumed error of the model is added to the random errors, so
    that resonances of the model need not coincide with those of the structure. Every difference is attributed
    to the coefficients; an influence of the rig is therefore an error, unless the structure includes it.

    Parameters
    ----------
    target
        Receptances at sensors and forces of the structure, with their random errors.

    Raises
    ------
    InvalidInputError
        If the structure's damping is that of its modes.
    UnderdeterminedError
        If there are fewer measured numbers than coefficients and the options refuse these, or no
        response moves with any coefficient.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    return update_on_responses(structure, parameterisation, target, options, progress)


RESPONSE_UPDATERS.register("frf_residual")(
    UpdatingMethod(frf_residual, ResponseUpdateOptions, parts=MASS_STIFFNESS_AND_DAMPING)
)
