"""Updating of large plates: against one factorisation and the fewest solves, and how it grows with size.

python -m benchmarks updating_scale
"""

import re
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import Assembly, Coefficients, assemble, coefficients_of
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.lowest_modes import factorised
from modallab.fe.modes import first_basis, undamped_basis
from modallab.fe.plate import plate
from modallab.fe.structure import Material, Structure
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.updating.method import UPDATERS
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import Parameterisation, parameterise
from modallab.updating.sensitivity import PartMatrices, derivatives, part_matrices

LENGTH, WIDTH, THICKNESS = 0.6, 0.4, 0.004  # m
STEEL = Material(2.09e11, 7800.0)
SIZES = {
    600: (16, 11),
    1_600: (27, 18),
    5_000: (50, 33),
    20_000: (100, 65),
    100_000: (222, 149),
}  # elements each way, by DoFs
MODES, SENSORS, STEPS = 20, (6, 5), 5
MEASURED, MACROS = 10, (10, 5)  # modes, and macro elements with a mass and a stiffness each
MANY = (25, 20)  # macro elements of a thousand coefficients
ROUNDS = 5
CHANGED = 0.1  # standard deviation of what a coefficient moves by in a step
WRONG = {7: 1.3, 23: 0.8, 38: 1.2}  # stiffness, by macro element
MEMORY = 24e6  # kB
GROWTH = 1.4  # power of the number of degrees of freedom


def plate_of(n_dofs: int) -> Structure:
    """Return a free steel plate with about so many DoFs."""
    return plate(length=LENGTH, width=WIDTH, thickness=THICKNESS, n_elements=SIZES[n_dofs], material=STEEL)


def patches(n_dofs: int, count: tuple[int, int]) -> list[tuple[int, ...]]:
    """Return the plates by number in so many rectangles along and across."""
    along, across = SIZES[n_dofs]
    columns, rows = (np.arange(n) * k // n for n, k in zip((along, across), count, strict=True))
    place = (rows[:, None] * count[0] + columns).ravel()
    return [tuple(int(n) for n in np.flatnonzero(place == i) + 1) for i in range(count[0] * count[1])]


def sensors(n_dofs: int) -> tuple[Dof, ...]:
    """Return 6 by 5 places from edge to edge where motion across the plate is measured."""
    along, across = SIZES[n_dofs]
    columns, rows = (np.linspace(0, n, k).astype(int) for n, k in zip((along, across), SENSORS, strict=True))
    return tuple(Dof(int(row * (along + 1) + column + 1), "Z") for row in rows for column in columns)


def random_coefficients(assembly: Assembly, seed: int) -> Coefficients:
    """Return stiffnesses a step away from 1 in every macro element."""
    base = coefficients_of(assembly.structure)
    steps = np.random.default_rng(seed).normal(scale=CHANGED, size=50)
    factor = np.exp(steps)[np.arange(len(base.mass)) * 50 // len(base.mass)]
    return Coefficients(base.mass, base.axial, base.bending * factor, base.loss_factor)


def eigen_solution(n_dofs: int, rounds: int) -> float:
    """Return the time of modes from those a step away, over one factorisation and a solve a mode."""
    assembly = Assembly(plate_of(n_dofs))
    initial, changed = assembly.system(), assembly.system(random_coefficients(assembly, 1))
    basis = first_basis(initial.mass, initial.stiffness, initial.rigid, MODES)
    near = basis.shapes[:, basis.n_rigid_body :].real
    loads = np.random.default_rng(0).standard_normal((len(initial.dofs), MODES))

    def ours() -> object:
        return undamped_basis(
            changed.mass, changed.stiffness, changed.rigid, frequency_max=basis.frequency_max, near=near
        )

    def least() -> object:
        return factorised(changed.stiffness + changed.mass).solve(loads)

    return ratio(ours, least, rounds)


def jacobian(n_dofs: int, macros: tuple[int, int], rounds: int) -> float:
    """Return the time of all derivatives at the sensors, over a solve a sensor and a pass of the elements."""
    assembly = Assembly(plate_of(n_dofs))
    system = assembly.system()
    basis = first_basis(system.mass, system.stiffness, system.rigid, MODES)
    modes = basis.n_rigid_body + np.arange(MEASURED)
    places = system.selection(sensors(n_dofs))
    parameters = parameterise(patches(n_dofs, macros))
    parts = part_matrices(assembly, coefficients_of(assembly.structure), parameters)
    remainder = basis.remainder
    assert remainder is not None
    answers, shapes = remainder.static(places), basis.shapes[:, modes].real
    solve = remainder.solve

    def ours() -> object:
        fresh = replace(basis, remainder=replace(remainder))  # with nothing kept from the round before
        return derivatives(fresh, modes, places, parts)

    def least() -> object:
        solve(places)
        return [element_pass(part, answers, shapes) for part in parts]

    return ratio(ours, least, rounds)


def element_pass(part: PartMatrices, left_factor: FloatArray, right: FloatArray) -> FloatArray:
    """Return left^T A right of every element: gathered, multiplied, and not yet added up."""
    return np.asarray(left_factor[part.rows].swapaxes(1, 2) @ (part.matrices @ right[part.rows]))


def case(n_dofs: int) -> tuple[Structure, Parameterisation, ModalModel]:
    """Return a plate, its coefficients, and modes of one of which three macro elements are wrong."""
    structure = plate_of(n_dofs)
    groups = patches(n_dofs, MACROS)
    wrong = [MemberChange(groups[i], MemberProperty.MODULUS, factor=f) for i, f in WRONG.items()]
    truth, rng = assemble(change(structure, wrong)), np.random.default_rng(0)
    measured = synthetic_modes(truth, MEASURED, sensors(n_dofs), noise=ModeNoise(), rng=rng)
    return structure, parameterise(groups), measured


def measure(n_dofs: int) -> None:
    """Update a plate in `STEPS` iterations; print the seconds, the most memory, kB, and the largest error."""
    structure, parameters, measured = case(n_dofs)
    options = UpdateOptions(max_iterations=STEPS, tolerance=1e-12)
    start = time.process_time()
    result = UPDATERS["one_shot"](structure, parameters, measured, options=options)
    seconds = time.process_time() - start
    match = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
    assert match is not None
    coefficients = [result.coefficients[macro.part][macro.members[0]] for macro in parameters.macros]
    n_macros = len(coefficients) // 2
    truth = [1.0] * n_macros + [WRONG.get(i, 1.0) for i in range(n_macros)]
    error = float(np.abs(np.subtract(coefficients, truth)).max())
    print(seconds, match[1], error, result.iterations["updating"])


def updated(n_dofs: int) -> tuple[float, float, float]:
    """Return seconds, kB and the largest error of a coefficient of an update in a process of its own."""
    code = f"from benchmarks import updating_scale; updating_scale.measure({n_dofs})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    seconds, memory, error, steps = (float(number) for number in run.stdout.split())
    assert steps == STEPS
    return seconds, memory, error


def run(
    small: int = 20_000, large: int = 100_000, macros: tuple[int, int] = MANY, rounds: int = ROUNDS
) -> list[tuple[str, float, float]]:
    """Return (name, figure, limit); sizes in DoFs, of `SIZES`."""
    (fewer_seconds, _, _), (seconds, memory, error) = updated(small), updated(large)
    power = np.log(seconds / fewer_seconds) / np.log(large / small)
    whole = f"{large:,} DoFs, {2 * MACROS[0] * MACROS[1]} coefficients, {STEPS} steps"
    many = f"{2 * macros[0] * macros[1]:,} coefficients at {SENSORS[0] * SENSORS[1]} sensors"
    return [
        (
            f"{MODES} modes of {small:,} DoFs, from a step away / factor, solves",
            eigen_solution(small, rounds),
            4.0,
        ),
        (f"{many} / solves, element pass", jacobian(small, macros, rounds), 1.5),
        (f"{whole}: growth, power of size", float(power), GROWTH),
        (f"{whole}: memory over 24 GB", memory / MEMORY, 1.0),
        (f"{whole}: largest error", error, 1e-3),
    ]


BENCH = Bench(run, short=partial(run, small=600, large=1_600, macros=MACROS, rounds=1), reads_proc=True)
