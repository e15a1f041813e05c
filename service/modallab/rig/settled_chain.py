"""A measuring chain whose resonances all die away within the lead-in of simulated records."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.attachment import Attachment
from modallab.fe.modes import ModalBasis
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import Chain
from modallab.rig.nonlinear_settings import NONLINEAR_RECORDS, TIME_STEPPING
from modallab.rig.run import Run


def settled_chain(chain: Chain) -> Chain:
    """Return a chain with as much damping of each mode that it dies away within the longest lead-in.

    A body that moves on nothing but a nonlinear spring rings on for ever in a model, so that no simulated
    record is steady. Whoever measures waits until one is, or has more damping than the model. Damping of a
    mode alone: M phi c phi^T M leaves all others as they are.
    """
    lead_in = NONLINEAR_RECORDS.max_lead_in / chain.setup.analyser.spacing
    least = -2 * np.log(NONLINEAR_RECORDS.decay_threshold) / lead_in
    runs = tuple(_settled(run, chain.setup.analyser.frequency_max, least) for run in chain.runs)
    return chain if all(a is b for a, b in zip(runs, chain.runs, strict=True)) else replace(chain, runs=runs)


def _settled(run: Run, frequency_max: float, least: float) -> Run:
    """Return a run of which each mode in the band has a damping, twice its rate of decay, of `least` 1/s."""
    system = run.with_exciters.folded()
    basis = system.modes(frequency_max)
    omega = 2 * np.pi * basis.frequencies
    missing = least - 2 * basis.decay_rates(TIME_STEPPING.rigid_body_rate)
    slow = (omega > TIME_STEPPING.rigid_body_rate) & (basis.frequencies < frequency_max) & (missing > 0)
    if not slow.any():
        return run
    columns = _momenta(system, basis)[: len(run.system.dofs), slow]
    return replace(run, system=run.system.attach(Attachment(columns, viscous=np.diag(missing[slow]))))


def _momenta(system: DynamicSystem, basis: ModalBasis) -> FloatArray:
    """Return the momenta (n, m) of modes of unit velocity."""
    return np.asarray(system.mass @ basis.shapes.real)
