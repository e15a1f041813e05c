"""Rules that name what is surely a slip: one function a rule, its limits in `plausibility_settings`."""

from collections.abc import Callable, Iterator, Sequence
from math import sqrt
from typing import TypeVar

import numpy as np

from modallab.core.errors import ModalLabError
from modallab.core.physics_warning import PhysicsWarning
from modallab.fe.members import Material, Member, Plate, Section
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes
from modallab.rig.exact import as_modelled
from modallab.rig.measurement import Measurement
from modallab.rig.plausibility_settings import PLAUSIBLE
from modallab.rig.setup import RigSetup

Warnings = Iterator[PhysicsWarning]
T = TypeVar("T")


def structure_warnings(structure: Structure) -> tuple[PhysicsWarning, ...]:
    """Return what is surely a slip in a structure: of a material, a section, a length.

    What follows of several numbers is looked at only where each by itself is that of a structure.
    """
    return _by_rules(STRUCTURE_RULES, structure) or _by_rules(COMBINATION_RULES, structure)


def rig_warnings(setup: RigSetup) -> tuple[PhysicsWarning, ...]:
    """Return what is surely a slip in a rig: settings with which a test says nothing."""
    return _by_rules(RIG_RULES, setup)


def measurement_warnings(measurement: Measurement) -> tuple[PhysicsWarning, ...]:
    """Return what is surely a slip in a measurement and its log book."""
    return _by_rules(MEASUREMENT_RULES, measurement)


def modulus(structure: Structure) -> Warnings:
    """Yield materials softer than gels, or stiffer than diamond."""
    for material in _materials(structure):
        if not _inside(material.modulus, PLAUSIBLE.modulus):
            words = f"a modulus of {material.modulus:g} N/m^2 is that of no solid"
            yield PhysicsWarning(
                "modulus", f"{words}: steel has 2.1e11, rubber 1e6; was it in GPa?", "modulus"
            )


def density(structure: Structure) -> Warnings:
    """Yield materials lighter than foams, or heavier than osmium."""
    for material in _materials(structure):
        if not _inside(material.density, PLAUSIBLE.density):
            words = f"a density of {material.density:g} kg/m^3 is that of no solid"
            yield PhysicsWarning(
                "density", f"{words}: steel has 7800, foam 30; was it in g/cm^3 or t/m^3?", "density"
            )


def wave_speed(structure: Structure) -> Warnings:
    """Yield materials in which waves are slower than in rubber, or faster than in diamond.

    Modulus and density may each be that of a solid, and together those of none: a modulus in MPa.
    """
    for material in _materials(structure):
        speed = sqrt(material.modulus / material.density)
        if not _inside(speed, PLAUSIBLE.wave_speed):
            words = f"longitudinal waves at {speed:.3g} m/s, sqrt(modulus/density), exist in no solid"
            yield PhysicsWarning(
                "wave_speed",
                f"{words}: steel has 5200 m/s; do the units of modulus and density agree?",
                "modulus",
            )


def extent(structure: Structure) -> Warnings:
    """Yield a structure longer than any that is tested with an exciter: coordinates in mm."""
    size = _extent(structure)
    if size > PLAUSIBLE.extent:
        words = f"the structure is {size:g} m long"
        yield PhysicsWarning(
            "extent", f"{words}, more than any that is tested; was the length in mm?", "length"
        )


def section(structure: Structure) -> Warnings:
    """Yield sections whose second moment of area belongs to no shape of their area."""
    sections: dict[tuple[float, float], Section] = {
        (member.section.area, member.section.second_moment): member.section for member in structure.members
    }
    for area, second_moment in sections:
        if not _inside(second_moment / area**2, PLAUSIBLE.compactness):
            words = f"no shape has an area of {area:g} m^2 and a second moment of {second_moment:g} m^4"
            yield PhysicsWarning("section", f"{words}; was one of them in mm?", "second_moment")


def thickness(structure: Structure) -> Warnings:
    """Yield plates thicker than the structure is long: a thickness in mm."""
    size = _extent(structure)
    plates = [member.thickness for member in structure.non_bar_members if isinstance(member, Plate)]
    for value in dict.fromkeys(plates):
        if size > 0 and value > size:
            words = f"a plate of {value:g} m is thicker than the structure of {size:g} m is long"
            yield PhysicsWarning("thickness", f"{words}; was the thickness in mm?", "thickness")


def first_frequency(structure: Structure) -> Warnings:
    """Yield a small structure whose first elastic mode is slower or faster than that of any structure."""
    if len(structure.dofs) > PLAUSIBLE.solved_dofs:
        return
    try:
        basis, _ = lowest_modes(as_modelled(structure), 1)
    except ModalLabError:  # it has no elastic mode, or none can be found: other requests say so
        return
    frequency = float(basis.frequencies[0]) if len(basis.frequencies) else PLAUSIBLE.frequency[0]
    if not _inside(frequency, PLAUSIBLE.frequency):
        words = f"the first elastic mode lies at {frequency:.3g} Hz"
        yield PhysicsWarning(
            "first_frequency", f"{words}, where no structure under test has it; do all units agree?", "length"
        )


def one_average(setup: RigSetup) -> Warnings:
    """Yield a test of one average.

    For one record |G_xf|^2 = G_xx G_ff, so that the coherence is 1 whatever the noise.
    """
    if setup.analyser.averages == 1:
        yield _of_one_average("analyser.averages")


def band_without_lines(setup: RigSetup) -> Warnings:
    """Yield a source that drives where the analyser has no line."""
    analyser = setup.analyser
    band = analyser.excitation.band
    if band is None:
        return
    if not np.any((analyser.freq >= band[0]) & (analyser.freq <= band[1])):
        words = f"the source drives from {band[0]:g} to {band[1]:g} Hz, where the analyser has no line"
        lines = f"its lines lie from {analyser.frequency_min:g} to {analyser.frequency_max:g} Hz"
        yield PhysicsWarning("band_without_lines", f"{words}: {lines}", "analyser.excitation.band")


def top_frequency(setup: RigSetup) -> Warnings:
    """Yield a test that ends below the frequencies of what an exciter drives: a range in kHz."""
    top = setup.analyser.frequency_max
    if top < PLAUSIBLE.top_frequency:
        yield PhysicsWarning(
            "top_frequency", f"the test ends at {top:g} Hz; was the range in kHz?", "analyser.frequency_max"
        )


def rig_of_measurement(measurement: Measurement) -> Warnings:
    """Yield the warnings of the log book."""
    yield from rig_warnings(measurement.setup)


def measured_once(measurement: Measurement) -> Warnings:
    """Yield a measurement that states one average where its log book states none."""
    if measurement.averages == 1 and measurement.setup.analyser.averages is None:
        yield _of_one_average("averages")


STRUCTURE_RULES: Sequence[Callable[[Structure], Warnings]] = (
    modulus,
    density,
    extent,
    section,
    thickness,
)
COMBINATION_RULES: Sequence[Callable[[Structure], Warnings]] = (wave_speed, first_frequency)
RIG_RULES: Sequence[Callable[[RigSetup], Warnings]] = (one_average, band_without_lines, top_frequency)
MEASUREMENT_RULES: Sequence[Callable[[Measurement], Warnings]] = (
    rig_of_measurement,
    measured_once,
)


def _by_rules(rules: Sequence[Callable[[T], Warnings]], thing: T) -> tuple[PhysicsWarning, ...]:
    return tuple(warning for rule in rules for warning in rule(thing))


def _of_one_average(field: str) -> PhysicsWarning:
    words = "with one average the coherence is 1 by definition, and random errors cannot be told"
    return PhysicsWarning("one_average", words, field)


def _materials(structure: Structure) -> Sequence[Material]:
    """Return the different materials of bars and plates."""
    carriers = [member for member in structure.all_members if isinstance(member, Member | Plate)]
    return tuple(dict.fromkeys(member.material for member in carriers))


def _extent(structure: Structure) -> float:
    """Return the largest extent of the nodes along an axis, m."""
    places = np.array(list(structure.nodes.values()), dtype=float)
    return float(np.ptp(places, axis=0).max())


def _inside(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]
