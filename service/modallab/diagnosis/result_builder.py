"""What was found, written down: effects with their errors, rivals, curves."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import gap_error
from modallab.diagnosis.result import (
    EquivalentEffect,
    FittedEffect,
    FittedParameter,
    Rival,
    Step,
    ToleratedParameter,
)
from modallab.diagnosis.result_curves import Curves, Spectra
from modallab.diagnosis.searching.acceptance import model_probabilities
from modallab.diagnosis.searching.search_path import AcceptedEffect
from modallab.diagnosis.test_design.proposal import alike, named
from modallab.fe.structure import Structure
from modallab.rig.effect import Effect
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

MOST_ALIKE = 3
# Share of the effects named first that were there, of diagnoses that left something unexplained: 7 of 14 in
# a blind trial of singles, pairs and causes that no catalogue holds.
INCOMPLETE = 0.5


def _fitted(fit: Fit, i: int) -> FittedEffect:
    effect, errors = fit.effects[i], fit.errors[i]
    numbers = {
        name: FittedParameter(effect.parameters[name], errors[name], spec.unit)
        for name, spec in effect.specs().items()
    }
    return FittedEffect(effect.kind, effect.at, numbers)


def tolerated(predictor: Predictor, best: Fit) -> tuple[ToleratedParameter, ...]:
    """Return what may differ a little, as it was fitted."""
    each = zip(predictor.nuisances.parameters, best.nuisance_position, best.nuisance_errors, strict=True)
    return tuple(
        ToleratedParameter(
            name=one.name,
            at=one.at,
            mode=one.mode,
            value=one.value(float(position)),
            standard_error=one.standard_deviation * float(error),
            tolerance=one.standard_deviation,
            unit=one.unit,
        )
        for one, position, error in each
    )


def rivals(predictor: Predictor, tried: Sequence[Fit], but: Fit | None = None) -> tuple[Rival, ...]:
    """Return the fits of a round as rivals, best first, without the one named."""
    where = predictor.observed.fitted
    shares = model_probabilities(predictor, tried)
    return tuple(
        Rival(f.effects[-1].kind, f.effects[-1].at, share, f.residual.gap(where))
        for f, share in zip(tried, shares, strict=True)
        if f is not but
    )


def step(predictor: Predictor, accepted: AcceptedEffect, final: Fit, *, explained: bool) -> Step:
    """Return what one effect closed.

    Parameters
    ----------
    final
        The fit of all effects together.
    explained
        Whether only noise is left of it. If not, what is missing may be none of the rivals.
    """
    observed, tried = predictor.observed, accepted.round_fits
    chosen = named(accepted)
    near = alike(predictor, accepted, chosen)
    shares = dict(zip(map(id, tried), model_probabilities(predictor, tried), strict=True))
    # Sizes from the last fit: what was missing beside an effect still distorts its own round's.
    position = [(e.kind, str(e.at)) for e in final.effects].index(accepted.kind_and_place)
    return Step(
        effect=_fitted(final, position),
        probability=shares[id(chosen)] * (1.0 if explained else INCOMPLETE),
        gap_before=accepted.previous_fit.residual.gap(observed.fitted),
        gap_after=accepted.fit.residual.gap(observed.fitted),
        held_out_gap_before=accepted.previous_fit.residual.gap(observed.held_out_mask),
        held_out_gap_after=accepted.fit.residual.gap(observed.held_out_mask),
        held_out_scatter=gap_error(observed, accepted.fit.residual, observed.held_out_mask),
        rivals=rivals(predictor, tried, chosen),
        rivals_alike=tuple(EquivalentEffect(f.effects[-1].kind, f.effects[-1].at) for f in near[:MOST_ALIKE]),
    )


def extended(structure: Structure, setup: RigSetup, effects: Sequence[Effect]) -> tuple[Structure, RigSetup]:
    """Return model and log book with what was added."""
    for effect in effects:
        if effect.structural:
            structure = effect.added_to(structure)
        else:
            setup = replace(setup, effects=(*setup.effects, effect.spec))
    return structure, setup


def curves(predictor: Predictor, measurement: Measurement, best: Fit, unmeasured: tuple[Dof, ...]) -> Curves:
    """Return the curves of the first test, with responses that were not measured predicted."""
    predictor = predictor.tests[0]
    observed: Observed = predictor.observed
    fitted = predictor.with_nuisances_at(best.nuisance_position)
    predicted = fitted.unmeasured_inertance(best.effects, unmeasured) if unmeasured else None
    before, after = predictor.predict(()), fitted.predict(best.effects)
    return Curves(
        freq=observed.freq,
        measured=observed.h[..., None],
        before=before.h[..., None],
        after=after.h[..., None],
        random_error=observed.error[..., None],
        held_out=observed.held_out,
        outputs=measurement.frf.outputs,
        inputs=measurement.frf.inputs,
        predicted=predicted,
        predicted_outputs=unmeasured,
        force=_spectra(observed.force, before.force, after.force, observed.force_variance),
        incoherent=_spectra(
            observed.incoherent, before.incoherent, after.incoherent, observed.incoherent_variance
        ),
    )


def _spectra(
    measured: FloatArray | None, before: FloatArray, after: FloatArray, variance: FloatArray | float | None
) -> Spectra | None:
    if measured is None or variance is None:
        return None
    return Spectra(measured, before, after, np.sqrt(np.broadcast_to(variance, measured.shape)))
