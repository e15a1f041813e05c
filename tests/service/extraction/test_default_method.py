"""Method of an extraction where none is named."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.default_method import default_method
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping, DistantLinesOptions, ExtractionOptions

FREQ = np.arange(95.0, 140.0, 0.0625)
FREQUENCIES = np.array([98.0, 105.2, 125.21, 125.58, 134.0])  # Hz: a weak mode, and a pair in one peak
LOSS_FACTORS = np.array([0.004, 0.004, 0.004, 0.0045, 0.005])


def light_aircraft(n_ref: int) -> FrfSet:
    """Return inertances of twenty points, with noise of 1 % of each FRF's rms."""
    rng = np.random.default_rng(5)
    shapes, driven = rng.standard_normal((5, 20, 1)), rng.standard_normal((5, 1, n_ref))
    driven[1] *= 0.03
    constant = (shapes * driven).reshape(5, -1)
    omega2 = (2 * np.pi * FREQ[:, None]) ** 2
    poles = (2 * np.pi * FREQUENCIES) ** 2 * (1 + 1j * LOSS_FACTORS)
    exact = -omega2 * ((1 / (poles - omega2)) @ constant)
    parts = rng.standard_normal((2, *exact.shape))
    noise = 0.01 * np.sqrt((np.abs(exact) ** 2).mean(axis=0) / 2)
    values = (exact + noise * (parts[0] + 1j * parts[1])).reshape(len(FREQ), 20, n_ref)
    outputs = tuple(Dof(node, "Z") for node in range(1, 21))
    return FrfSet(FREQ, values, outputs, outputs[:n_ref], FrfKind.INERTANCE)


def test_the_default_with_several_references_finds_a_close_pair_and_a_weak_mode() -> None:
    model = extract(light_aircraft(3), coherence=None, averages=1.0)
    assert model.method == "poly_reference_lscf"
    assert model.choices["method"].startswith("poly_reference_lscf: the default with 3 references")
    # a tenth of the pair's distance
    np.testing.assert_allclose(model.frequencies, FREQUENCIES, rtol=3e-4)


def test_a_method_that_was_named_is_as_requested() -> None:
    model = extract(light_aircraft(2), coherence=None, averages=1.0, method="circle_fit", n_modes=2)
    assert model.choices["method"] == "circle_fit: as requested"


@pytest.mark.parametrize(
    ("n_references", "options", "method"),
    [
        (1, None, "dobson"),
        (1, ExtractionOptions(damping=Damping.VISCOUS), "dobson"),
        (2, None, "poly_reference_lscf"),
        (6, DistantLinesOptions(), "poly_reference_lscf"),
        (7, None, "lscf"),
        (3, DistantLinesOptions(lines=14), "dobson"),
        (3, DistantLinesOptions(leave_out=2), "dobson"),
    ],
)
def test_references_and_options_choose_the_method(
    n_references: int, options: ExtractionOptions | None, method: str
) -> None:
    choice = default_method(n_references, options)
    assert choice.method == method
    assert choice.reason.startswith(f"{method}: the default with")
