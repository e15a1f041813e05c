"""Updating on frequency responses: what all coefficients came to, how sure, and which are wrong."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import UnderdeterminedError
from modallab.core.progress import Progress
from modallab.fe.assembly import Assembly
from modallab.fe.structure import Structure
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.iteration import Ending
from modallab.updating.method import REGULARISED, Stages, UpdateOptions, UpdateResult
from modallab.updating.one_stage_path import Rule, unweighted
from modallab.updating.parameterisation import Parameterisation, by_member
from modallab.updating.quantities import quantities
from modallab.updating.responses.correct import BEGINNING, EXPLAINED, ResponsePath, correct
from modallab.updating.responses.fields import ResponseModel
from modallab.updating.responses.result import ResponseFit
from modallab.updating.responses.rows import log_ratios, mean_square
from modallab.updating.responses.target import TargetResponses
from modallab.updating.significance import standard_errors, suspected
from modallab.updating.sparse_bayes import Prior

MOST = 40_000  # real numbers that coefficients are found by; lines beyond are held out


def update_on_responses(
    structure: Structure,
    parameterisation: Parameterisation,
    target: TargetResponses,
    options: UpdateOptions,
    progress: Progress,
) -> UpdateResult:
    """Return the model corrected to the responses, and how it was found."""
    model = CorrectedModel(Assembly(structure, jumps=True), parameterisation)
    whole = ResponseModel(model, target)
    chosen = target.at(target.evenly(MOST))
    refuse_few(chosen, len(parameterisation.macros), options)
    fitted = ResponseModel(model, chosen)
    beginning = ResponseModel(model, chosen.at(chosen.evenly(BEGINNING)))
    rule = Rule(Prior(options.prior), options.tolerance, options.max_iterations, options.rank_jump)
    path = correct(fitted, beginning, rule, progress)
    told = _identified(parameterisation, path, options)
    made_sense = path.ending is not Ending.DIVERGED
    corrected, parts = model.structure(path.values), parameterisation.parts
    numbers = [member.number for member in corrected.all_members]
    frequencies, none = _frequencies(model, path.values, float(target.freq.max())), np.zeros(0)
    return UpdateResult(
        structure=corrected,
        coefficients=by_member(parameterisation, path.values, parts=parts, members=numbers),
        standard_errors=standard_errors(parameterisation, path.values, path.belief) if made_sense else {},
        suspected=suspected(parameterisation, path.values, path.belief),
        frequencies=frequencies,
        mac=Stages(none, none, none),
        history=path.history,
        converged=path.ending is Ending.CONVERGED,
        stopped_because=path.why + _unexplained(path),
        rank=told.rank,
        condition_number=told.condition_number,
        intervals=told.by_member() if made_sense else {},
        identifiability=told if made_sense else None,
        quantities=quantities(structure, parameterisation, path.values, told if made_sense else None),
        responses=_fit(whole, chosen, path),
    )


def refuse_few(target: TargetResponses, n_params: int, options: UpdateOptions) -> None:
    """Raise `UnderdeterminedError` if there are too few measured numbers, unless the prior is to decide."""
    if target.n_numbers < n_params and options.underdetermined != REGULARISED:
        raise UnderdeterminedError(
            f"{target.n_numbers} measured numbers cannot determine {n_params} coefficients",
            field="macros",
            value=n_params,
            allowed=f"<= {target.n_numbers}, two for each response at a line",
        )


def _unexplained(path: ResponsePath) -> str:
    """Return by how much responses are missed, as words to add; nothing if errors explain it."""
    if path.after < EXPLAINED:
        return ""
    return f"; responses are missed by {np.sqrt(path.after):.2g} times their random errors"


def _identified(
    parameterisation: Parameterisation, path: ResponsePath, options: UpdateOptions
) -> Identifiability:
    """Return what the data say without the prior, each band as uncertain as it turned out to be."""
    linear = path.linear
    scales = np.maximum(path.belief.scales, linear.floors**2)[linear.block]
    missed = linear.values / np.sqrt(scales)
    step = unweighted(linear.matrix / np.sqrt(scales)[:, None], missed, options.rank_jump)
    known = np.ones(len(missed))
    return identify(parameterisation, path.values, step, missed, known, within=options.identified_within)


def _frequencies(model: CorrectedModel, values: FloatArray, top: float) -> Stages:
    """Return the elastic modes of the model, before and after, as many as it had in the band at first."""
    before, after = (
        model.system(at).modes(top).elastic().frequencies for at in (model.parameterisation.unchanged, values)
    )
    count = int((before <= top).sum())
    return Stages(before[:count], before[:count], after[:count])


def _fit(whole: ResponseModel, chosen: TargetResponses, path: ResponsePath) -> ResponseFit:
    """Return how well the model's responses are the measured ones, at lines used and held out."""
    target = whole.target
    used = np.isin(target.freq, chosen.freq)
    left = [
        log_ratios(target, whole.receptance(values))
        for values in (whole.parameterisation.unchanged, path.values)
    ]
    before, after = (
        [mean_square(one[part], target.at(np.flatnonzero(part))) for part in (used, ~used)] for one in left
    )
    by_frf = [mean_square(one[used], chosen, axis=(0,)) for one in left]
    held = int((~used).sum())
    return ResponseFit(
        freq=chosen.freq,
        outputs=target.outputs,
        inputs=target.inputs,
        before=float(before[0]),
        after=float(after[0]),
        scatter=float(np.sqrt(2 / chosen.n_numbers)),
        by_frf_before=by_frf[0],
        by_frf_after=by_frf[1],
        n_held_out=held,
        held_out_before=float(before[1]) if held else None,
        held_out_after=float(after[1]) if held else None,
    )
