"""Updating in one stage: coefficients, their errors and the suspected members."""

import numpy as np

from modallab.core.errors import UnderdeterminedError
from modallab.core.progress import Progress, part
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.iteration import IterationPath, StopReason, stated_end
from modallab.updating.method import Stages, UpdateResult
from modallab.updating.modal_residuals import ModalResiduals
from modallab.updating.one_stage_path import OneStagePath, OneStageRule, correct, least_squares_step
from modallab.updating.options import OneStageOptions, Underdetermined
from modallab.updating.parameterisation import Parameterisation, by_member
from modallab.updating.quantities import quantities
from modallab.updating.sampling import sample
from modallab.updating.significance import standard_errors, suspected
from modallab.updating.sparse_bayes import Prior
from modallab.updating.target import TargetModes


def update_in_one_stage(
    structure: Structure,
    parameterisation: Parameterisation,
    measured: TargetModes,
    options: OneStageOptions,
    progress: Progress,
) -> UpdateResult:
    """Return the model corrected to the measured modes, all coefficients at once."""
    fit = _residuals(structure, parameterisation, measured, options)
    rule = OneStageRule(Prior(options.prior), options.tolerance, options.max_iterations, options.rank_jump)
    # Samples take much longer than the path that leads to them.
    path_fraction = 0.1 if options.samples else 1.0
    stage_path = _with_pairing_check(correct(fit, rule, part(progress, 0.0, path_fraction)), options.min_mac)
    initial, path, final = stage_path.initial, stage_path.iterations, stage_path.iterations.final
    identifiability = _identifiability(fit, stage_path, options)
    is_valid = path.stop_reason is not StopReason.DIVERGED
    valid_part = identifiability if is_valid else None
    has_errors = is_valid and _has_row_errors(fit, identifiability.rank)
    errors = standard_errors(parameterisation, final.values, stage_path.posterior) if has_errors else {}
    samples = options.samples if is_valid else 0
    sampling_progress = part(progress, path_fraction, 1.0)
    posterior = sample(fit, stage_path, samples, options.seed, sampling_progress) if samples else None
    corrected, parts = fit.structure(final.values), parameterisation.parts
    numbers = [member.number for member in corrected.all_members]
    return UpdateResult(
        structure=corrected,
        coefficients=by_member(parameterisation, final.values, parts=parts, members=numbers),
        standard_errors=errors,
        suspected=suspected(parameterisation, final.values, stage_path.posterior),
        frequencies=Stages(initial.frequencies, initial.frequencies, final.frequencies, measured.frequencies),
        mac=Stages(initial.mac, initial.mac, final.mac),
        history=path.history,
        converged=path.converged,
        stopped_because=stated_end(path.explanation, parameterisation, final.values, options.tolerance)
        + stage_path.weights.misfit_note(stage_path.posterior.block_variances),
        rank=identifiability.rank,
        condition_number=identifiability.condition_number,
        intervals=valid_part.by_member() if valid_part else {},
        identifiability=valid_part,
        quantities=quantities(structure, parameterisation, final.values, valid_part),
        posterior=posterior,
    )


def _residuals(
    structure: Structure, parameterisation: Parameterisation, measured: TargetModes, options: OneStageOptions
) -> ModalResiduals:
    """Return the residuals that are minimised.

    The first pairing has no lower limit of the MAC: the rows of a wrongly paired mode have a large misfit,
    and therefore a small weight.
    """
    return ModalResiduals(
        Assembly(structure, joint_rotations=True),
        parameterisation,
        measured,
        0.0,
        regularised=options.underdetermined is Underdetermined.REGULARISED,
    )


def _with_pairing_check(stage_path: OneStagePath, min_mac: float) -> OneStagePath:
    """Return the path, as diverged if a measured mode lost its partner.

    Raises
    ------
    UnderdeterminedError
        If a measured mode has no partner, neither at the start nor at the end.
    """
    unpaired = np.flatnonzero(stage_path.iterations.final.mac < min_mac)
    if not unpaired.size:
        return stage_path
    explanation = f"measured mode {unpaired[0] + 1} pairs with no mode of the model"
    never_paired = np.flatnonzero(
        (stage_path.iterations.final.mac < min_mac) & (stage_path.initial.mac < min_mac)
    )
    if never_paired.size:
        raise UnderdeterminedError(
            f"measured mode {never_paired[0] + 1} pairs with no mode of the model",
            field="modes",
            value=int(never_paired[0]) + 1,
            allowed=f"a MAC of {min_mac} with a mode of the model",
        )
    path = IterationPath(
        stage_path.iterations.history,
        stage_path.iterations.final,
        StopReason.DIVERGED,
        f"{StopReason.DIVERGED}: {explanation}",
    )
    return OneStagePath(stage_path.initial, path, stage_path.posterior, stage_path.weights)


def _identifiability(
    fit: ModalResiduals, stage_path: OneStagePath, options: OneStageOptions
) -> Identifiability:
    """Return the identifiability by the data alone, with the block variances of the posterior."""
    state, posterior = stage_path.iterations.final, stage_path.posterior
    errors = np.sqrt(posterior.block_variances[stage_path.weights.block])
    rows, residual = (linear.T / errors for linear in stage_path.weights.rows(fit, state))
    step = least_squares_step(rows.T, residual, options.rank_jump)
    row_errors = np.ones(len(residual)) if _has_row_errors(fit, step.rank) else None
    return identify(
        fit.parameterisation, state.values, step, residual, row_errors, within=options.identified_within
    )


def _has_row_errors(fit: ModalResiduals, rank: int) -> bool:
    """Return whether errors are stated, or can be estimated from more rows than the rank."""
    return fit.target.errors is not None or fit.target.n_rows > rank
