"""Location, then updating: macro elements first, then the elements inside them."""

from dataclasses import replace

import numpy as np

from modallab.core.progress import Progress, part
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.covariance import coefficient_covariance
from modallab.updating.iteration import Ending, IterationPath, StopRule, iterate
from modallab.updating.location import Suspicion, suspicion
from modallab.updating.method import Stages, UpdateOptions, UpdateResult
from modallab.updating.modal_residuals import Balance, ModalResiduals, State
from modallab.updating.parameterisation import Parameterisation, Part, by_member
from modallab.updating.quantities import quantities
from modallab.updating.target import TargetModes


def update_in_two_stages(
    structure: Structure,
    parameterisation: Parameterisation,
    measured: TargetModes,
    options: UpdateOptions,
    progress: Progress,
) -> UpdateResult:
    """Return the model corrected to the modes, and how it was found.

    Stage one moves the coefficients of the macro elements until they stand still; those that end
    away from no change are suspected. Stage two moves the elements inside them from where stage one
    ended, all others back at no change. 1992 thesis, chapter 3.
    """
    assembly, measured = Assembly(structure, jumps=True), replace(measured, n_shapes=options.n_shapes)
    balance = Balance(options.balance)
    whole = ModalResiduals(assembly, parameterisation, measured, options.min_mac, balance=balance)
    start = parameterisation.unchanged
    before = whole.state(start)
    rule = StopRule(options.location_tolerance, np.inf, options.max_iterations, options.rank_jump)
    located = iterate(whole, start, rule, stage="location", progress=part(progress, 0.0, 0.5))
    suspected = suspicion(
        parameterisation, located.final.values, options.suspect_threshold, options.damping_threshold
    )
    if located.ending is Ending.DIVERGED:
        fit, path = whole, IterationPath((), located.final, located.ending, located.why)
    elif suspected is None:
        fit, path = (
            whole,
            IterationPath((), before, located.ending, f"{located.why}; no macro element is suspected"),
        )
    else:
        fit = ModalResiduals(assembly, suspected.parameterisation, measured, options.min_mac, balance=balance)
        rule = StopRule(options.tolerance, options.max_step, options.max_iterations, options.rank_jump)
        path = iterate(fit, suspected.start, rule, stage="updating", progress=part(progress, 0.5, 1.0))
    return _result(before, located, suspected, fit, path, parameterisation.parts, options)


def _result(
    before: State,
    located: IterationPath,
    suspected: Suspicion | None,
    fit: ModalResiduals,
    path: IterationPath,
    parts: tuple[Part, ...],
    options: UpdateOptions,
) -> UpdateResult:
    final, moved = path.final, fit.parameterisation
    sure = coefficient_covariance(fit, final, jump=options.rank_jump, within=options.identified_within)
    told = sure.identifiability
    corrected_any = path.ending is not Ending.DIVERGED and suspected is not None
    errors = sure.standard_errors if corrected_any else None
    corrected = fit.structure(final.values)
    below = fit.losses_below_zero(final.values, options.tolerance)
    note = f"; {below} loss factors came out below zero and are zero in the structure" if below else ""
    numbers = [member.number for member in corrected.all_members]
    return UpdateResult(
        structure=corrected,
        coefficients=by_member(moved, final.values, parts=parts, members=numbers),
        standard_errors={} if errors is None else by_member(moved, errors, parts=parts),
        suspected=_members(suspected, parts),
        frequencies=Stages(
            before.frequencies, located.final.frequencies, final.frequencies, fit.target.frequencies
        ),
        mac=Stages(before.mac, located.final.mac, final.mac),
        history=located.history + path.history,
        converged=path.converged,
        stopped_because=path.why + note,
        rank=told.rank,
        condition_number=told.condition_number,
        intervals=told.by_member() if corrected_any else {},
        identifiability=told if corrected_any else None,
        quantities=quantities(fit.model.initial, moved, final.values, told if corrected_any else None),
    )


def _members(suspected: Suspicion | None, parts: tuple[Part, ...]) -> dict[str, tuple[int, ...]]:
    macros = () if suspected is None else suspected.parameterisation.macros
    return {part.value: tuple(sorted(m.members[0] for m in macros if m.part is part)) for part in parts}
