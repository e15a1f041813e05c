"""FRFs at DoFs that were not measured, from model, log book and effects."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.rig.chain import chain
from modallab.rig.channel import Channel
from modallab.rig.effect import Effect


def unmeasured_inertance(
    predictor: SingleTestPredictor, effects: Sequence[Effect], dofs: tuple[Dof, ...]
) -> ComplexArray:
    """Return the inertance (n_freq, n_dof, n_in), 1/kg, at DoFs that were not measured.

    A roving accelerometer visits them; fixed ones stay where they are.
    """
    setup, freq = predictor.setup, predictor.observed.freq
    system, acting = predictor.model.deviating_system, predictor.acting(effects)
    n_in, n_simultaneous = len(setup.drives), setup.n_simultaneous
    if setup.accelerometers.roving:
        visited = chain(system, replace(setup, responses=dofs), acting)
        by_run = visited.respond(freq).inertance[:, :, 0]
        by_blow = by_run.reshape(n_in // n_simultaneous, len(dofs), len(freq), n_simultaneous)
        return np.asarray(by_blow.transpose(2, 1, 0, 3).reshape(len(freq), len(dofs), n_in))
    runs = tuple(
        replace(
            run,
            acquisition_run=replace(run.acquisition_run, outputs=dofs),
            responses=tuple(map(Channel.ideal, dofs)),
        )
        for run in chain(system, setup, acting).runs
    )
    by_run = replace(chain(system, setup), runs=runs).respond(freq).inertance
    return np.asarray(by_run.transpose(1, 2, 0, 3).reshape(len(freq), len(dofs), n_in))
