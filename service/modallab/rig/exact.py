"""Exact FRFs of a structure with its modelled effects, without a rig."""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.fe.assembly import assemble
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.analyser import Analyser
from modallab.rig.chain import chain
from modallab.rig.effect import build
from modallab.rig.setup import AcquisitionRun, RigSetup


def as_modelled(structure: Structure) -> DynamicSystem:
    """Return the matrices of a structure with the linear effects that its model carries.

    Effects that differ from run to run are evaluated for the first run.
    """
    effects = sorted((build(spec) for spec in structure.effects), key=lambda effect: effect.at is not None)
    system = assemble(structure)
    for effect in effects:
        system = effect.on_system(system, AcquisitionRun((), ()))
    return system


def with_effects(structure: Structure) -> Structure:
    """Return the structure with its effects moved into members, masses and springs where possible.

    Others stay effects.
    """
    plain = replace(structure, effects=())
    for spec in structure.effects:
        plain = build(spec).added_to(plain)
    return plain


def exact_frf(
    structure: Structure, drive: Dof, responses: Sequence[Dof], *, frequency_max: float, n_lines: int
) -> FrfSet:
    """Return the FRFs that an ideal rig measures: inertance, 1/kg, (n_lines, n_out, 1).

    The line at 0 Hz is the limit from above, to 1e-5. Nonlinear forces are their straight lines under
    a random force of 1 N rms.

    Parameters
    ----------
    frequency_max
        Hz, of the last line; the first is at 0 Hz.
    n_lines
        How many, 0 Hz counted.

    Raises
    ------
    UnknownDofError
        If the structure has no such DoF.
    InvalidInputError
        If the lines are out of bounds, or a DoF is a rotation or named twice.
    """
    analyser = Analyser(frequency_max=frequency_max, n_lines=n_lines)
    setup = RigSetup(drives=(drive,), responses=tuple(responses), analyser=analyser)
    ideal = chain(assemble(structure), setup, [build(spec) for spec in structure.effects])
    values = ideal.respond(analyser.freq).inertance[0]
    return FrfSet(analyser.freq, values, setup.responses, setup.drives, FrfKind.INERTANCE)
