"""Nuisance parameters of a test: which of them its tolerances leave free."""

from collections.abc import Mapping

from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels, Place
from modallab.diagnosis.optimisation.nuisances import FIELDS, NO_FIELD, Nuisance, Nuisances
from modallab.diagnosis.optimisation.random_field import RandomField
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.fe.system import DynamicSystem
from modallab.rig.setup import RigSetup


def nuisance_parameters(
    tolerances: Tolerances, system: DynamicSystem, setup: RigSetup, *, damping_unknown: bool = False
) -> Nuisances:
    """Return the nuisance parameters of a test.

    A roving accelerometer has one sensitivity and one delay; of several accelerometers each has its own.

    Parameters
    ----------
    system
        The model without transducers.
    damping_unknown
        Whether the loss factor of each elastic mode is free, over two decades.
    """
    places: list[Place] = [None] if setup.accelerometers.roving else [Channels((d,)) for d in setup.responses]
    nuisances: list[Nuisance] = []
    if tolerances.modulus:
        nuisances.append(Nuisance("modulus", tolerances.modulus, 1.0, "1"))
    if tolerances.density:
        nuisances.append(Nuisance("density", tolerances.density, 1.0, "1"))
    if tolerances.sensitivity:
        nuisances += [Nuisance("sensitivity", tolerances.sensitivity, 1.0, "1", at) for at in places]
    if tolerances.accelerometer_mass and setup.accelerometers.mass:
        nuisances.append(Nuisance("accelerometer_mass", tolerances.accelerometer_mass, 1.0, "1"))
    if tolerances.delay:
        nuisances += [Nuisance("delay", tolerances.delay, 0.0, "s", at) for at in places]
    loss_factors: tuple[float, ...] = ()
    if tolerances.modal_loss_factor or damping_unknown:
        loss_factors, n_near = _loss_factors(system, setup.analyser.frequency_max)
        stated = tolerances.modal_loss_factor or 0.0
        deviation = NUISANCE.unknown_loss_factor if damping_unknown else stated
        nuisances += [
            Nuisance("modal_loss_factor", deviation, 1.0, "1", mode=i, logarithmic=True, optional=i > n_near)
            for i, eta in enumerate(loss_factors, 1)
            if eta > 0
        ]
    field = NO_FIELD
    if deviations := {name: value for name in FIELDS if (value := getattr(tolerances, name))}:
        field = _field(system, deviations)
        for name, deviation in deviations.items():
            nuisances += [
                Nuisance(name, deviation, 0.0, "1", shape=i, optional=i >= field.n_large)
                for i in range(len(field))
            ]
    return Nuisances(tuple(nuisances), setup.accelerometers.mass, loss_factors, field, damping_unknown)


def _field(system: DynamicSystem, deviations: Mapping[str, float]) -> RandomField:
    if system.members is None:
        name = next(iter(deviations))
        raise InvalidInputError(
            "the model has no members that could deviate", field=f"tolerances.{name}", allowed=[0.0]
        )
    return RandomField.of(system.members, max(deviations.values()))


def _loss_factors(system: DynamicSystem, frequency_max: float) -> tuple[tuple[float, ...], int]:
    """Return the loss factors of elastic modes, and how many of them are in the band or near it."""
    top, near = (ratio * frequency_max for ratio in (NUISANCE.loss_reach, NUISANCE.loss_margin))
    basis = system.modes(top).elastic()
    loss_factors = basis.loss_factors[basis.frequencies <= top]
    return tuple(loss_factors.tolist()), int((basis.frequencies <= near).sum())
