"""Construction of a diagnosis's result from the fits: effects, rivals, extended model, curves."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.optimisation.nuisances import FIELDS, Nuisances
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.unmeasured import unmeasured_inertance
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import gap_error
from modallab.diagnosis.result import (
    EquivalentEffect,
    FittedEffect,
    FittedParameter,
    Rival,
    Step,
    ToleratedParameter,
)
from modallab.diagnosis.result_curves import DiagnosisCurves, Spectra
from modallab.diagnosis.searching.acceptance import model_probabilities
from modallab.diagnosis.searching.equivalent_fits import equivalent_fits, named_fit
from modallab.diagnosis.searching.search_path import AcceptedEffect
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.fe.structure import Structure
from modallab.rig.effect import Effect
from modallab.rig.frf_channel import FrfLayout, stands_for_response
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup


def _fitted(fit: Fit, i: int, *, level_known: bool) -> FittedEffect:
    effect, errors = fit.effects[i], fit.errors[i]

    def parameter(name: str, unit: str) -> FittedParameter:
        if not level_known and name in effect.level_dependent:
            return FittedParameter(np.nan, np.nan, unit)
        return FittedParameter(effect.parameters[name], errors[name], unit)

    parameters = {name: parameter(name, spec.unit) for name, spec in effect.specs().items()}
    return FittedEffect(effect.kind, effect.at, parameters)


def tolerated(predictor: Predictor, best: Fit) -> tuple[ToleratedParameter, ...]:
    """Return the nuisance parameters, as fitted; of random fields the factor of each member."""
    nuisances = predictor.nuisances
    estimates = zip(nuisances.parameters, best.nuisance_position, best.nuisance_errors, strict=True)
    single = tuple(
        ToleratedParameter(
            name=nuisance.name,
            at=nuisance.at,
            mode=nuisance.mode,
            value=nuisance.value(float(position)),
            standard_error=nuisance.standard_error(float(position), float(error)),
            tolerance=nuisance.standard_deviation,
            unit=nuisance.unit,
        )
        for nuisance, position, error in estimates
        if nuisance.shape is None
    )
    return single + tuple(row for name in FIELDS for row in _factors_of_members(nuisances, best, name))


def _factors_of_members(nuisances: Nuisances, best: Fit, name: str) -> list[ToleratedParameter]:
    """Return the factor of each member that a random field gives."""
    indices = nuisances.indices_of(name)
    if not len(indices):
        return []
    deviation = nuisances.parameters[indices[0]].standard_deviation
    shapes, covariance = nuisances.shapes_of(name), best.nuisance_covariance[np.ix_(indices, indices)]
    factors = np.exp(nuisances.field.logarithms(deviation, best.nuisance_position[indices], shapes))
    errors = factors * nuisances.field.standard_errors(deviation, covariance, shapes)
    return [
        ToleratedParameter(name, float(factor), float(error), deviation, "1", Members((number,)))
        for number, factor, error in zip(nuisances.field.numbers, factors, errors, strict=True)
    ]


def rivals(predictor: Predictor, candidates: Sequence[Fit], chosen: Fit | None = None) -> tuple[Rival, ...]:
    """Return the fits of a round, except the chosen one, as rivals, best first."""
    probability = model_probabilities(predictor, candidates)
    return tuple(
        Rival(f.effects[-1].kind, f.effects[-1].at, p, f.residual.gap(predictor.observed.fitted))
        for f, p in zip(candidates, probability, strict=True)
        if f is not chosen
    )


def step(predictor: Predictor, accepted: AcceptedEffect, final: Fit) -> Step:
    """Return one added effect with its probability, gaps and rivals.

    Parameters
    ----------
    final
        Fit of all effects together.
    """
    observed, candidates = predictor.observed, accepted.round_fits
    chosen = named_fit(accepted)
    equivalent = equivalent_fits(predictor, accepted, chosen)[: DIAGNOSIS.max_equivalent_effects]
    probability = dict(zip(map(id, candidates), model_probabilities(predictor, candidates), strict=True))
    # Parameters from the final fit: effects that were still missing in the effect's own round distort them.
    position = [(e.kind, str(e.at)) for e in final.effects].index(accepted.kind_and_place)
    return Step(
        effect=_fitted(final, position, level_known=any(test.level_known for test in predictor.tests)),
        probability=probability[id(chosen)],
        gap_before=accepted.previous_fit.residual.gap(observed.fitted),
        gap_after=accepted.fit.residual.gap(observed.fitted),
        held_out_gap_before=accepted.previous_fit.residual.gap(observed.held_out_mask),
        held_out_gap_after=accepted.fit.residual.gap(observed.held_out_mask),
        held_out_scatter=gap_error(observed, accepted.fit.residual, observed.held_out_mask),
        rivals=rivals(predictor, candidates, chosen),
        rivals_alike=tuple(EquivalentEffect(f.effects[-1].kind, f.effects[-1].at) for f in equivalent),
    )


def extended(structure: Structure, setup: RigSetup, effects: Sequence[Effect]) -> tuple[Structure, RigSetup]:
    """Return model and log book with the added effects."""
    for effect in effects:
        if effect.structural:
            structure = effect.added_to(structure)
        else:
            setup = replace(setup, effects=(*setup.effects, effect.spec))
    return structure, setup


def curves(
    predictor: Predictor, measurement: Measurement, best: Fit, unmeasured: tuple[Dof, ...]
) -> DiagnosisCurves:
    """Return measured and predicted curves of the first test.

    Parameters
    ----------
    best
        Fit of all effects together.
    unmeasured
        DoFs that were not measured, whose FRFs are predicted.
    """
    predictor = predictor.tests[0]
    observed: Observed = predictor.observed
    fitted = predictor.with_nuisances_at(best.nuisance_position)
    predicted = unmeasured_inertance(fitted, best.effects, unmeasured) if unmeasured else None
    initial, final = predictor.predict(()), fitted.predict(best.effects)
    by_dofs = FrfLayout.of(observed.channels, measurement.frf.outputs, measurement.frf.inputs).by_dofs
    held_out = by_dofs(observed.held_out)
    return DiagnosisCurves(
        freq=observed.freq,
        measured=by_dofs(observed.h),
        before=by_dofs(initial.h),
        after=by_dofs(final.h),
        random_error=by_dofs(observed.error),
        held_out=held_out if held_out.shape[1] > 1 else held_out[:, 0],
        outputs=measurement.frf.outputs,
        inputs=measurement.frf.inputs,
        predicted=predicted,
        predicted_outputs=unmeasured,
        force=_spectra(
            observed.force, initial.force, final.force, observed.force_variance, _forces_in_order(observed)
        ),
        incoherent=_spectra(
            _incoherent(observed, initial),
            initial.incoherent,
            final.incoherent,
            observed.incoherent_variance,
            np.flatnonzero(stands_for_response(observed.channels)),
        ),
    )


def _incoherent(observed: Observed, initial: Predicted) -> FloatArray | None:
    """Return the incoherent spectra; those over the force at the expected one."""
    if observed.incoherent is None or not observed.per_force:
        return observed.incoherent
    return observed.incoherent * observed.force_of_channels(initial)


def _forces_in_order(observed: Observed) -> IntArray:
    """Return the force spectra drive point by drive point, as the FRFs of a result are."""
    drives = list(dict.fromkeys(channel.drive for channel in observed.channels))
    first = np.unique(observed.forces, return_index=True)[1]
    return np.argsort([drives.index(observed.channels[i].drive) for i in first], kind="stable")


def _spectra(
    measured: FloatArray | None,
    initial: FloatArray,
    final: FloatArray,
    variance: FloatArray | float | None,
    columns: IntArray,
) -> Spectra | None:
    if measured is None or variance is None:
        return None
    error = np.sqrt(np.broadcast_to(variance, measured.shape))
    return Spectra(*(array[:, columns] for array in (measured, initial, final, error)))
