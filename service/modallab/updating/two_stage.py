"""Two-stage updating: location by macro elements, then correction of the members inside them."""

from dataclasses import replace

import numpy as np

from modallab.core.progress import Progress, part
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.covariance import coefficient_covariance
from modallab.updating.iteration import IterationPath, StopReason, StopRule, iterate, stated_end
from modallab.updating.location import Suspicion, suspect_members
from modallab.updating.method import Stages, UpdateResult
from modallab.updating.modal_residuals import Balance, ModalResiduals, ModelState
from modallab.updating.options import TwoStageOptions
from modallab.updating.parameterisation import Parameterisation, Part, by_member
from modallab.updating.quantities import quantities
from modallab.updating.target import TargetModes


def update_in_two_stages(
    structure: Structure,
    parameterisation: Parameterisation,
    measured: TargetModes,
    options: TwoStageOptions,
    progress: Progress,
) -> UpdateResult:
    """Return the model corrected to the measured modes, in two stages.

    Stage one iterates the coefficients of macro elements to convergence; those that end away from nominal are
    suspected. Stage two iterates the coefficients of their members from the values of stage one, all others
    at nominal. 1992 thesis, chapter 3.
    """
    assembly = Assembly(structure, joint_rotations=True)
    measured = replace(measured, n_shapes=options.n_shapes)
    balance = Balance(options.balance)
    macro_residuals = ModalResiduals(assembly, parameterisation, measured, options.min_mac, balance=balance)
    start = parameterisation.nominal
    initial = macro_residuals.state(start)
    rule = StopRule(options.location_tolerance, np.inf, options.max_iterations, options.rank_jump)
    location_path = iterate(macro_residuals, start, rule, stage="location", progress=part(progress, 0.0, 0.5))
    suspicion = suspect_members(
        parameterisation, location_path.final.values, options.suspect_threshold, options.loss_factor_threshold
    )
    if location_path.stop_reason is StopReason.DIVERGED:
        fit, path = (
            macro_residuals,
            IterationPath((), location_path.final, location_path.stop_reason, location_path.explanation),
        )
    elif suspicion is None:
        fit, path = (
            macro_residuals,
            IterationPath(
                (),
                initial,
                location_path.stop_reason,
                f"{location_path.explanation}; no macro element is suspected",
            ),
        )
    else:
        fit = ModalResiduals(assembly, suspicion.parameterisation, measured, options.min_mac, balance=balance)
        rule = StopRule(options.tolerance, options.max_step, options.max_iterations, options.rank_jump)
        path = iterate(fit, suspicion.start, rule, stage="updating", progress=part(progress, 0.5, 1.0))
    return _result(initial, location_path, suspicion, fit, path, parameterisation.parts, options)


def _result(
    initial: ModelState,
    location_path: IterationPath,
    suspicion: Suspicion | None,
    fit: ModalResiduals,
    path: IterationPath,
    parts: tuple[Part, ...],
    options: TwoStageOptions,
) -> UpdateResult:
    final, parameterisation = path.final, fit.parameterisation
    covariance = coefficient_covariance(fit, final, jump=options.rank_jump, within=options.identified_within)
    identifiability = covariance.identifiability
    has_correction = path.stop_reason is not StopReason.DIVERGED and suspicion is not None
    valid_part = identifiability if has_correction else None
    errors = covariance.standard_errors if has_correction else None
    corrected = fit.structure(final.values)
    n_negative = fit.count_negative_loss_factors(final.values, options.tolerance)
    note = (
        f"; {n_negative} loss factors came out below zero and are zero in the structure" if n_negative else ""
    )
    numbers = [member.number for member in corrected.all_members]
    return UpdateResult(
        structure=corrected,
        coefficients=by_member(parameterisation, final.values, parts=parts, members=numbers),
        standard_errors={} if errors is None else by_member(parameterisation, errors, parts=parts),
        suspected=_suspected_members(suspicion, parts),
        frequencies=Stages(
            initial.frequencies, location_path.final.frequencies, final.frequencies, fit.target.frequencies
        ),
        mac=Stages(initial.mac, location_path.final.mac, final.mac),
        history=location_path.history + path.history,
        converged=path.converged,
        stopped_because=stated_end(path.explanation, parameterisation, final.values, options.tolerance)
        + note,
        rank=identifiability.rank,
        condition_number=identifiability.condition_number,
        intervals=valid_part.by_member() if valid_part else {},
        identifiability=valid_part,
        quantities=quantities(fit.model.initial, parameterisation, final.values, valid_part),
    )


def _suspected_members(suspicion: Suspicion | None, parts: tuple[Part, ...]) -> dict[str, tuple[int, ...]]:
    macros = () if suspicion is None else suspicion.parameterisation.macros
    return {
        part.value: tuple(sorted(n for m in macros if m.part is part for n in m.members)) for part in parts
    }
