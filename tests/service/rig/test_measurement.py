"""A measurement is of one kind, and of the others as well."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.rigs import rig, steel_beam

NOISY = rig(1, 5, 11, noise=Noise(1e-3, 1e-3))
TWO_SHAKERS = replace(NOISY, drives=(NOISY.responses[0], NOISY.responses[2]))
STRUCK = replace(NOISY.analyser, excitation=ExcitationSetting("impact"))
HAMMER = replace(TWO_SHAKERS, exciter=Exciter(kind="hammer"), analyser=STRUCK)
SETUPS = {"one shaker": NOISY, "two shakers": TWO_SHAKERS, "a roving hammer": HAMMER}


TIED = np.array([[1.0, 0.5j], [-0.5j, 1.0]])
IMPOSSIBLE = {
    "not Hermitian": np.array([[1.0, 0.5j], [0.5j, 1.0]]),
    "more in common than they are": np.array([[1.0, 2.0], [2.0, 1.0]]),
    "negative": -np.eye(2),
}


@pytest.mark.parametrize("matrix", IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_matrices_that_no_forces_have_are_refused(matrix: ComplexArray) -> None:
    test = measure(steel_beam(), TWO_SHAKERS, route=Route.EXPECTED, rng=np.random.default_rng(1))
    spectra = np.zeros((*test.frf.values.shape, 2), complex)
    assert replace(test, force_cross_spectra=spectra + TIED).force_cross_spectra is not None
    with pytest.raises(InvalidInputError, match="cross spectra") as refused:
        replace(test, force_cross_spectra=spectra + matrix)
    assert refused.value.context["field"] == "force_cross_spectra"


@pytest.fixture(scope="module", params=SETUPS)
def inertance(request: pytest.FixtureRequest) -> Measurement:
    """A drawn measurement, which has random errors in every array."""
    setup = SETUPS[request.param]
    return measure(steel_beam(), setup, route=Route.DRAWN, rng=np.random.default_rng(1))


def arrays(measurement: Measurement) -> dict[str, FloatArray]:
    """Return every array that has a frequency axis."""
    names = ("coherence", "force_spectrum", "response_spectrum", "input_condition", "force_cross_spectra")
    held = {name: getattr(measurement, name) for name in names}
    there = {name: array for name, array in held.items() if array is not None}
    return there | {"freq": measurement.frf.freq, "values": measurement.frf.values}


def test_what_is_of_a_kind_already_is_itself(inertance: Measurement) -> None:
    assert inertance.to(FrfKind.INERTANCE) is inertance


@pytest.mark.parametrize("kind", [FrfKind.RECEPTANCE, FrfKind.MOBILITY])
def test_there_and_back_is_where_it_was_above_rest(inertance: Measurement, kind: FrfKind) -> None:
    other = inertance.to(kind)
    assert other.frf.kind is kind
    back, before = arrays(other.to(FrfKind.INERTANCE)), arrays(inertance)
    assert back.keys() == before.keys()
    for name, array in back.items():
        # a product and a quotient by omega^4 at most: eight roundings
        np.testing.assert_allclose(array, before[name][1:], rtol=1e-14, err_msg=name)


@pytest.mark.parametrize("kind", [FrfKind.RECEPTANCE, FrfKind.MOBILITY])
def test_the_line_at_rest_is_left_out_of_every_array_and_a_note_says_so(
    inertance: Measurement, kind: FrfKind
) -> None:
    other = inertance.to(kind)
    assert {len(array) for array in arrays(other).values()} == {400}
    assert other.frf.freq[0] == inertance.frf.freq[1]
    (note,) = set(other.notes) - set(inertance.notes)
    assert note == f"inertance at 0 Hz has no {kind}: that line is left out"
    # what has no such line to lose has nothing to tell
    assert other.to(FrfKind.INERTANCE).notes == other.notes
    assert other.to(FrfKind.INERTANCE).to(kind).notes == other.notes


@pytest.mark.parametrize("kind", FrfKind)
def test_spectra_and_frfs_of_every_kind_tell_the_same_coherence(kind: FrfKind) -> None:
    one = measure(steel_beam(), NOISY, route=Route.DRAWN, rng=np.random.default_rng(1)).to(kind)
    assert one.force_spectrum is not None
    assert one.response_spectrum is not None
    # gamma^2 = |H1|^2 G_ff/G_xx holds only if G_xx is of the motion that H is of
    told = np.abs(one.frf.values) ** 2 * one.force_spectrum / one.response_spectrum[..., None]
    assert one.coherence is not None
    np.testing.assert_allclose(told[..., 0], one.coherence, rtol=1e-9)  # rounding of the estimator


def test_receptance_brought_in_with_its_line_at_rest_becomes_inertance_that_rests_there() -> None:
    inertance = measure(steel_beam(), NOISY, route=Route.DRAWN, rng=np.random.default_rng(1))
    brought = replace(inertance, frf=replace(inertance.frf, kind=FrfKind.RECEPTANCE))
    found = brought.to(FrfKind.INERTANCE)
    assert len(found.frf.freq) == 401
    assert found.notes == brought.notes
    assert (found.frf.values[0] == 0).all()
    assert found.response_spectrum is not None
    assert brought.response_spectrum is not None
    assert (found.response_spectrum[0] == 0).all()
    # -omega^2 and omega^4, from the definition
    omega = 2 * np.pi * brought.frf.freq
    np.testing.assert_allclose(
        found.frf.values, -(omega[:, None, None] ** 2) * brought.frf.values, rtol=1e-14
    )
    np.testing.assert_allclose(
        found.response_spectrum, omega[:, None] ** 4 * brought.response_spectrum, rtol=1e-14
    )
