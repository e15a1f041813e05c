"""Updating in one stage: what all coefficients came to, how sure, and which are wrong."""

import numpy as np

from modallab.core.errors import UnderdeterminedError
from modallab.core.progress import Progress, part
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.iteration import Ending, IterationPath
from modallab.updating.method import REGULARISED, Stages, UpdateOptions, UpdateResult
from modallab.updating.modal_residuals import ModalResiduals
from modallab.updating.one_stage_path import OneStagePath, Rule, correct, unweighted
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
    options: UpdateOptions,
    progress: Progress,
) -> UpdateResult:
    """Return the model corrected to the modes, and how it was found."""
    # A mode of far wrong elements may look like none of the model's at first: its rows count little until
    # it does, so that any partner will do to begin with.
    fit = ModalResiduals(
        Assembly(structure, jumps=True),
        parameterisation,
        measured,
        0.0,
        regularised=options.underdetermined == REGULARISED,
    )
    rule = Rule(Prior(options.prior), options.tolerance, options.max_iterations, options.rank_jump)
    # Draws take much longer than the path to where they begin.
    corrected_by = 0.1 if options.samples else 1.0
    whole = _paired(correct(fit, rule, part(progress, 0.0, corrected_by)), options.min_mac)
    before, path, final = whole.before, whole.path, whole.path.final
    told = _identified(fit, whole, options)
    made_sense = path.ending is not Ending.DIVERGED
    errors_known = made_sense and _judged(fit, told.rank)
    posterior = None
    if options.samples and made_sense:
        posterior = sample(fit, whole, options.samples, options.seed, part(progress, corrected_by, 1.0))
    corrected, parts = fit.structure(final.values), parameterisation.parts
    numbers = [member.number for member in corrected.all_members]
    return UpdateResult(
        structure=corrected,
        coefficients=by_member(parameterisation, final.values, parts=parts, members=numbers),
        standard_errors=standard_errors(parameterisation, final.values, whole.belief) if errors_known else {},
        suspected=suspected(parameterisation, final.values, whole.belief),
        frequencies=Stages(before.frequencies, before.frequencies, final.frequencies, measured.frequencies),
        mac=Stages(before.mac, before.mac, final.mac),
        history=path.history,
        converged=path.converged,
        stopped_because=path.why + whole.weights.missed(whole.belief.scales),
        rank=told.rank,
        condition_number=told.condition_number,
        intervals=told.by_member() if made_sense else {},
        identifiability=told if made_sense else None,
        quantities=quantities(structure, parameterisation, final.values, told if made_sense else None),
        posterior=posterior,
    )


def _paired(whole: OneStagePath, min_mac: float) -> OneStagePath:
    """Return the path, diverged if it lost a mode.

    Raises
    ------
    UnderdeterminedError
        If a measured mode looks like none of the model, before and after.
    """
    lost = np.flatnonzero(whole.path.final.mac < min_mac)
    if not lost.size:
        return whole
    why = f"measured mode {lost[0] + 1} pairs with no mode of the model"
    never = np.flatnonzero((whole.path.final.mac < min_mac) & (whole.before.mac < min_mac))
    if never.size:
        raise UnderdeterminedError(
            f"measured mode {never[0] + 1} pairs with no mode of the model",
            field="modes",
            value=int(never[0]) + 1,
            allowed=f"a MAC of {min_mac} with a mode of the model",
        )
    path = IterationPath(whole.path.history, whole.path.final, Ending.DIVERGED, f"{Ending.DIVERGED}: {why}")
    return OneStagePath(whole.before, path, whole.belief, whole.weights)


def _identified(fit: ModalResiduals, whole: OneStagePath, options: UpdateOptions) -> Identifiability:
    """Return what the data say without the prior, each block as uncertain as it turned out to be."""
    state, belief = whole.path.final, whole.belief
    errors = np.sqrt(belief.scales[whole.weights.block])
    rows, missed = (linear.T / errors for linear in whole.weights.rows(fit, state))
    step = unweighted(rows.T, missed, options.rank_jump)
    known = np.ones(len(missed)) if _judged(fit, step.rank) else None
    return identify(fit.parameterisation, state.values, step, missed, known, within=options.identified_within)


def _judged(fit: ModalResiduals, rank: int) -> bool:
    """Return whether errors are stated, or more rows than the coefficients meet show how large they are."""
    return fit.target.errors is not None or fit.target.n_rows > rank
