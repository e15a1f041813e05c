"""The free beam of the 1992 thesis, chapter 5, its exact modes and its eleven FRFs."""

from dataclasses import dataclass

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change

DRIVE = Dof(1, "Y")
RESPONSES = tuple(Dof(node, "Y") for node in range(1, 22, 2))


@dataclass(frozen=True)
class Beam:
    """Each FRF is of the structure with the accelerometer at its own response."""

    eigenvalues: ComplexArray  # (8, 11)
    constants: ComplexArray  # (8, 11) 1/kg
    all_eigenvalues: ComplexArray  # (42, 11) rigid bodies first
    all_constants: ComplexArray  # (42, 11)

    @property
    def frequencies(self) -> FloatArray:
        return np.sqrt(self.eigenvalues.real) / (2 * np.pi)

    @property
    def loss_factors(self) -> FloatArray:
        return self.eigenvalues.imag / self.eigenvalues.real

    def receptance(self, freq: FloatArray) -> ComplexArray:
        gap = self.all_eigenvalues - ((2 * np.pi * freq) ** 2)[..., None, None]
        values: ComplexArray = (self.all_constants / gap).sum(axis=-2)
        return values

    def frf(self, freq: FloatArray) -> FrfSet:
        inertance = np.zeros((len(freq), len(RESPONSES)), complex)
        above = freq > 0
        inertance[above] = -((2 * np.pi * freq[above, None]) ** 2) * self.receptance(freq[above])
        return FrfSet(freq, inertance[:, :, None], RESPONSES, (DRIVE,), FrfKind.INERTANCE)


def beam(accelerometer: float, force_transducer: float, *changes: MemberChange) -> Beam:
    system = assemble(change(STRUCTURES["chapter-5-beam"](), changes))
    system = system.add_mass(1, force_transducer)
    eigenvalues, constants = [], []
    for response in RESPONSES:
        basis = system.add_mass(response.node, accelerometer).modes()
        shapes = basis.shapes
        eigenvalues.append(basis.eigenvalues)
        constants.append(shapes[system.index(response)] * shapes[system.index(DRIVE)])
    all_eigenvalues, all_constants = np.array(eigenvalues).T, np.array(constants).T
    return Beam(all_eigenvalues[2:10], all_constants[2:10], all_eigenvalues, all_constants)


@pytest.fixture(scope="session")
def freq() -> FloatArray:
    return np.linspace(0.0, 800.0, 401)


@pytest.fixture(scope="session")
def plain_beam() -> Beam:
    return beam(0.0, 0.0)


@pytest.fixture(scope="session")
def roving_beam() -> Beam:
    """The hidden structure of the thesis with 20 g roving and 10 g at the drive point."""
    return beam(
        0.02,
        0.01,
        MemberChange((1, 2), MemberProperty.DENSITY, factor=2.0),
        MemberChange((11, 12), MemberProperty.MODULUS, factor=2.0),
    )
