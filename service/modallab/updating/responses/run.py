"""Updating on frequency responses: coefficients, their errors and the suspected members."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import UnderdeterminedError, bounds
from modallab.core.progress import Progress
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.iteration import StopReason, stated_end
from modallab.updating.method import Stages, UpdateResult
from modallab.updating.one_stage_path import OneStageRule, least_squares_step
from modallab.updating.options import ResponseUpdateOptions, Underdetermined
from modallab.updating.parameterisation import Parameterisation, by_member
from modallab.updating.quantities import quantities
from modallab.updating.responses.correct import ResponsePath, correct
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.result import ResponseFit
from modallab.updating.responses.rows import log_ratios, mean_square
from modallab.updating.responses.settings import RESPONSE_PATH
from modallab.updating.responses.target import TargetResponses
from modallab.updating.significance import standard_errors, suspected
from modallab.updating.sparse_bayes import Prior


def update_on_responses(
    structure: Structure,
    parameterisation: Parameterisation,
    target: TargetResponses,
    options: ResponseUpdateOptions,
    progress: Progress,
) -> UpdateResult:
    """Return the model corrected to the measured responses, all coefficients at once."""
    model = CorrectedModel(Assembly(structure, joint_rotations=True), parameterisation)
    full_model = ResponseModel(model, target)
    fitted_target = target.at(target.evenly_spaced(RESPONSE_PATH.max_numbers))
    check_determined(fitted_target, len(parameterisation.macros), options)
    fitted_model = ResponseModel(model, fitted_target)
    coarse_lines = fitted_target.evenly_spaced(RESPONSE_PATH.coarse_numbers)
    coarse_model = ResponseModel(model, fitted_target.at(coarse_lines))
    rule = OneStageRule(Prior(options.prior), options.tolerance, options.max_iterations, options.rank_jump)
    path = correct(fitted_model, coarse_model, rule, progress)
    identifiability = _identifiability(parameterisation, path, options)
    is_valid = path.stop_reason is not StopReason.DIVERGED
    valid_part = identifiability if is_valid else None
    corrected, parts = model.structure(path.values), parameterisation.parts
    numbers = [member.number for member in corrected.all_members]
    frequencies, no_modes = _frequencies(model, path.values, float(target.freq.max())), np.zeros(0)
    return UpdateResult(
        structure=corrected,
        coefficients=by_member(parameterisation, path.values, parts=parts, members=numbers),
        standard_errors=standard_errors(parameterisation, path.values, path.posterior) if is_valid else {},
        suspected=suspected(parameterisation, path.values, path.posterior),
        frequencies=frequencies,
        mac=Stages(no_modes, no_modes, no_modes),
        history=path.history,
        converged=path.stop_reason is StopReason.CONVERGED,
        stopped_because=stated_end(path.explanation, parameterisation, path.values, options.tolerance)
        + _misfit_note(path),
        rank=identifiability.rank,
        condition_number=identifiability.condition_number,
        intervals=valid_part.by_member() if valid_part else {},
        identifiability=valid_part,
        quantities=quantities(structure, parameterisation, path.values, valid_part),
        responses=_response_fit(full_model, fitted_target, path),
    )


def check_determined(target: TargetResponses, n_params: int, options: ResponseUpdateOptions) -> None:
    """Raise `UnderdeterminedError` for fewer measured numbers than coefficients, unless regularised."""
    if target.n_numbers < n_params and options.underdetermined is not Underdetermined.REGULARISED:
        raise UnderdeterminedError(
            f"{target.n_numbers} measured numbers cannot determine {n_params} coefficients",
            field="macros",
            value=n_params,
            allowed=bounds(maximum=target.n_numbers),
        )


def _misfit_note(path: ResponsePath) -> str:
    """Return a note on the misfit of responses; empty if errors explain it."""
    if path.final_mean_square < RESPONSE_PATH.explained_mean_square:
        return ""
    return f"; responses are missed by {np.sqrt(path.final_mean_square):.2g} times their random errors"


def _identifiability(
    parameterisation: Parameterisation, path: ResponsePath, options: ResponseUpdateOptions
) -> Identifiability:
    """Return the identifiability by the data alone, with the block variances of the posterior."""
    linear = path.linear
    scales = np.maximum(path.posterior.block_variances, linear.floors**2)[linear.block]
    residual = linear.values / np.sqrt(scales)
    step = least_squares_step(linear.matrix / np.sqrt(scales)[:, None], residual, options.rank_jump)
    row_errors = np.ones(len(residual))
    return identify(
        parameterisation, path.values, step, residual, row_errors, within=options.identified_within
    )


def _frequencies(model: CorrectedModel, values: FloatArray, top: float) -> Stages:
    """Return natural frequencies of the elastic modes in the band, before and after the update."""
    initial, updated = (
        model.system(at).modes(top).elastic().frequencies for at in (model.parameterisation.nominal, values)
    )
    count = int((initial <= top).sum())
    return Stages(initial[:count], initial[:count], updated[:count])


def _response_fit(
    full_model: ResponseModel, fitted_target: TargetResponses, path: ResponsePath
) -> ResponseFit:
    """Return the agreement of responses at fitted and held-out lines."""
    target = full_model.target
    is_fitted = np.isin(target.freq, fitted_target.freq)
    residuals = [
        log_ratios(target, full_model.receptance(values))
        for values in (full_model.parameterisation.nominal, path.values)
    ]
    initial, updated = (
        [mean_square(residual[part], target.at(np.flatnonzero(part))) for part in (is_fitted, ~is_fitted)]
        for residual in residuals
    )
    by_frf = [mean_square(residual[is_fitted], fitted_target, axis=(0,)) for residual in residuals]
    n_held_out = int((~is_fitted).sum())
    return ResponseFit(
        freq=fitted_target.freq,
        outputs=target.outputs,
        inputs=target.inputs,
        before=float(initial[0]),
        after=float(updated[0]),
        scatter=float(np.sqrt(2 / fitted_target.n_numbers)),
        by_frf_before=by_frf[0],
        by_frf_after=by_frf[1],
        n_held_out=n_held_out,
        held_out_before=float(initial[1]) if n_held_out else None,
        held_out_after=float(updated[1]) if n_held_out else None,
    )
