"""Error location by one linear step from the model."""

import numpy as np

from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.error_location.method import LOCATORS, LinearLocation, LinearProblem, LocationResult
from modallab.updating.iteration import check_sensitivity
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.options import LocationOptions
from modallab.updating.parameterisation import Parameterisation, by_member
from modallab.updating.target import real_modes

DEFAULTS = LocationOptions()


def locate(
    structure: Structure,
    parameterisation: Parameterisation,
    method: str,
    target: ModalModel,
    *,
    options: LocationOptions = DEFAULTS,
    progress: Progress = silent,
) -> LocationResult:
    """Return the members that a method suspects, at measured DoFs and modes without expansion.

    Parameters
    ----------
    method
        One of `LOCATORS`.
    target
        Measured modes; shapes that are not mass-normalised count up to their scale.

    Raises
    ------
    UnderdeterminedError
        If there are fewer measured numbers than coefficients, a measured mode has no partner, or no
        measured number depends on any coefficient.
    UnknownDofError
        If the structure lacks a measured DoF.
    """
    locator, measured = LOCATORS[method], real_modes(target)
    residuals = ModalResiduals(
        Assembly(structure, joint_rotations=True), parameterisation, measured, options.min_mac
    )
    progress(0.1, "the model is held against the measured modes")
    state = residuals.state(np.ones(len(parameterisation.macros)))
    sensitivity = residuals.sensitivity(state) / state.size[:, None]
    check_sensitivity(sensitivity)
    progress(0.6, f"{method} over {len(parameterisation.macros)} coefficients")
    problem = LinearProblem(sensitivity, state.difference / state.size)
    location = locator(problem, threshold=options.suspect_threshold, jump=options.rank_jump)
    return _result(method, parameterisation, location, residuals, state)


def _result(
    method: str,
    parameterisation: Parameterisation,
    location: LinearLocation,
    residuals: ModalResiduals,
    state: ModelState,
) -> LocationResult:
    parts = parameterisation.parts
    marked = by_member(parameterisation, location.suspected.astype(float), parts=parts)
    return LocationResult(
        method=method,
        changes=by_member(parameterisation, location.change, parts=parts),
        weights=by_member(parameterisation, location.weight, parts=parts),
        suspected={part: tuple(sorted(n for n, x in table.items() if x)) for part, table in marked.items()},
        remaining=location.remaining,
        measured=residuals.target.frequencies,
        frequencies=state.frequencies,
        mac=state.mac,
        rank=location.rank,
        condition_number=location.condition_number,
    )
