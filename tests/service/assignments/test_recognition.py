"""Uploaded FRFs are recognised as those of a measurement, however they were cut or rescaled."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.assignments.recognition import is_copy
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.place import EffectSpec
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.effect import build
from modallab.rig.hardware import Noise
from modallab.rig.measure import measure
from modallab.rig.setup import RigSetup

SETUP = RigSetup(
    drives=(Dof(1, "Y"),), responses=tuple(Dof(n, "Y") for n in (1, 6, 11, 21)), noise=Noise(1e-3, 1e-3)
)


def measured(seed: int, mass: float = 0.05) -> FrfSet:
    effects = [build(EffectSpec("extra_mass", Dof(6, "Y"), {"mass": mass}))] if mass else []
    beam = STRUCTURES["chapter-5-beam"]()
    return measure(beam, SETUP, effects, route="drawn", rng=np.random.default_rng(seed)).frf  # type: ignore[arg-type]


KNOWN = measured(1)


def with_values(frf: FrfSet, values: np.ndarray) -> FrfSet:
    return FrfSet(frf.freq, values, frf.outputs, frf.inputs, frf.kind)


def rounded(frf: FrfSet) -> FrfSet:
    parts = [
        [float(f"{part:.2e}") for part in column]
        for column in (frf.values.real.ravel(), frf.values.imag.ravel())
    ]
    return with_values(frf, (np.array(parts[0]) + 1j * np.array(parts[1])).reshape(frf.values.shape))


COPIES: dict[str, Callable[[FrfSet], FrfSet]] = {
    "as it is": lambda frf: frf,
    "one band": lambda frf: frf.between(100, 300),
    "every third line": lambda frf: FrfSet(frf.freq[::3], frf.values[::3], frf.outputs, frf.inputs, frf.kind),
    "one FRF under another name": lambda frf: FrfSet(
        frf.freq, frf.values[:, 2:3], (Dof(3, "Z"),), frf.inputs, frf.kind
    ),
    "in g": lambda frf: with_values(frf, frf.values / 9.81),
    "with the other sign": lambda frf: with_values(frf, -frf.values),
    "each at its own scale": lambda frf: with_values(frf, frf.values * np.arange(1, 5)[:, None]),
    "as receptance": lambda frf: frf.between(1, 1e6).to(FrfKind.RECEPTANCE),
    "receptance that is called inertance": lambda frf: with_values(
        frf.between(1, 1e6), frf.between(1, 1e6).to(FrfKind.RECEPTANCE).values
    ),
    "rounded to three digits": rounded,
}


@pytest.mark.parametrize("change", COPIES)
def test_a_copy_is_recognised(change: str) -> None:
    assert is_copy(COPIES[change](KNOWN), KNOWN)


@pytest.mark.parametrize(
    ("seed", "mass"), [(2, 0.05), (3, 0.04), (4, 0.0)], ids=["same test again", "another mass", "no mass"]
)
def test_another_measurement_is_none(seed: int, mass: float) -> None:
    assert not is_copy(measured(seed, mass), KNOWN)


def test_too_few_lines_are_no_evidence() -> None:
    assert not is_copy(KNOWN.between(100, 110), KNOWN)
    empty = FrfSet(
        np.array([1e6, 2e6]), np.ones((2, 1, 1), complex), KNOWN.outputs[:1], KNOWN.inputs, KNOWN.kind
    )
    assert not is_copy(empty, KNOWN)
