"""Leakage of a single mode, by closed form from its impulse response and the window's own correlation."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.correlation.evidence import Evidence
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.effects.leakage import Leakage
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.setup import RigSetup
from tests import oscillator
from tests.oscillator import DAMPING, FREQUENCY, MASS, OMEGA, RATIO, STIFFNESS

POLE = OMEGA * (-RATIO + 1j * np.sqrt(1 - RATIO**2))
Kernel = Callable[[ComplexArray], ComplexArray]


def triangle(a: ComplexArray) -> ComplexArray:
    """Integral of (1 - u) e^(a u) over 0 to 1: the correlation of a rectangular window with itself."""
    return np.asarray((np.exp(a) - 1 - a) / a**2)


def hann(a: ComplexArray) -> ComplexArray:
    """The same of a Hanning window: (1 - u) (2/3 + 1/3 cos 2 pi u) + sin(2 pi u) / (2 pi) in place of 1 - u.

    Its transform is the window's power spectrum, 1992 thesis [5.12, 5.13].
    """
    turn = 2j * np.pi
    return np.asarray(
        2 / 3 * triangle(a)
        + (triangle(a + turn) + triangle(a - turn)) / 6
        + (1 - np.exp(a)) / (a**2 + 4 * np.pi**2)
    )


KERNELS: dict[str, Kernel] = {"rectangular": triangle, "hann": hann}


def seen(kernel: Kernel, freq: FloatArray, length: float) -> tuple[ComplexArray, FloatArray]:
    """Cross and response spectra of a mode under white force of unit density, through a record of `length` s.

    Inertance is (1 + A/(i w - s) + its mirror)/m with A = s^2/(s - s*), and so A e^(s t) in time; its
    square is the transform of B e^(s |t|), B = s^4/((s - s*) (-2 s) (-s - s*)), and its mirror.
    """
    s, iw = POLE, np.asarray(2j * np.pi * freq, np.complex128)
    a = s**2 / (s - s.conj())
    b = s**4 / ((s - s.conj()) * (-2 * s) * (-s - s.conj()))

    def line(pole: complex, at: ComplexArray) -> ComplexArray:
        return np.asarray(length * kernel((pole - at) * length))

    cross = (1 + a * line(s, iw) + a.conj() * line(s.conj(), iw)) / MASS
    power = 1 + 2 * (b * (line(s, iw) + line(s, -iw))).real
    return cross, power / MASS**2


def exact(freq: FloatArray) -> ComplexArray:
    omega = 2 * np.pi * freq
    return np.asarray(-(omega**2) / (STIFFNESS - omega**2 * MASS + 1j * omega * DAMPING))


def rig_with(window: str, excitation: str, n_lines: int) -> RigSetup:
    return oscillator.rig_at_tip(excitation=excitation, window=window, n_lines=n_lines)


def test_the_closed_forms_are_those_of_the_windows() -> None:
    t = (np.arange(4096) + 0.5) / 4096
    for window, kernel in ((np.ones_like(t), triangle), (1 - np.cos(2 * np.pi * t), hann)):
        lags = np.correlate(window, window, "full")[4095:] / (window @ window)
        lags[0] /= 2  # the trapezoid rule: good to 1/4096^2 of its curvature
        for a in (-3.0 + 0.3j, -0.1 + 7j, -1 - 40j):
            by_sum = lags @ np.exp(a * np.arange(4096) / 4096) / 4096
            assert kernel(np.array([a]))[0] == pytest.approx(by_sum, abs=1e-4)


# Half-power bandwidths 2 x 0.005 x 54 Hz of 0.1 and 0.54 lines.
@pytest.mark.parametrize("n_lines", [101, 541])
@pytest.mark.parametrize(("window", "within"), [("hann", 1e-7), ("rectangular", 3e-3)])
def test_a_mode_under_random_force_is_smeared_as_its_closed_form_says(
    window: str, within: float, n_lines: int
) -> None:
    setup = rig_with(window, "random", n_lines)
    spectra = expected_spectra(chain(oscillator.system(), setup))
    freq, length = setup.analyser.freq, setup.analyser.record_length
    cross, power = seen(KERNELS[window], freq, length)
    density = oscillator.density(setup)
    near = np.abs(freq - FREQUENCY) < 0.5 * FREQUENCY
    # The closed form knows no end of the band, ten times the mode's frequency away: through a rectangular
    # window the far skirts, and their samples, are some 1e-3 of a line off the peak; Hanning's are gone.
    np.testing.assert_allclose(spectra.fx[0, near, 0, 0] / density, cross[near], rtol=within)
    np.testing.assert_allclose(spectra.xx[0, near, 0] / density, power[near], rtol=within)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.6])
@pytest.mark.parametrize("window", ["rectangular", "hann"])
def test_a_share_of_a_periodic_force_leaks_and_the_rest_stays_on_its_lines(window: str, share: float) -> None:
    setup = rig_with(window, "periodic_random", 541)
    spectra = expected_spectra(chain(oscillator.system(), setup, [Leakage(share=share)]))
    freq, length = setup.analyser.freq, setup.analyser.record_length
    h = exact(freq)
    shape = np.array({"rectangular": [0.0, 1.0, 0.0], "hann": [1 / 6, 2 / 3, 1 / 6]}[window])  # W, [5.13]
    smeared = seen(KERNELS[window], freq, length)
    cross, power = (
        (1 - share) * np.convolve(own, shape, "same") + share * leaked
        for own, leaked in zip((h, np.abs(h) ** 2), smeared, strict=True)
    )
    near = np.abs(freq - FREQUENCY) < 0.5 * FREQUENCY
    found = ESTIMATORS["h1"](spectra)[0, near, 0, 0]
    within = {"hann": 1e-7, "rectangular": 3e-3}[window]  # as above
    np.testing.assert_allclose(found, cross[near], rtol=within)
    g2 = np.abs(cross) ** 2 / power
    np.testing.assert_allclose(coherence(spectra)[0, near, 0], g2[near], rtol=within)


def test_coherence_drops_at_the_resonance_and_nowhere_else() -> None:
    spectra = expected_spectra(
        chain(oscillator.system(), rig_with("hann", "periodic_random", 541), [Leakage(share=0.3)])
    )
    drop = 1 - coherence(spectra)[0, 5:, 0]
    assert abs(5 + drop.argmax() - FREQUENCY) < 2  # lines of 1 Hz
    assert drop.max() > 0.05
    assert np.median(drop) < 1e-4


def test_shares_that_do_not_repeat_leave_the_product_of_what_does() -> None:
    setup = rig_with("hann", "periodic_random", 101)
    twice = chain(oscillator.system(), setup, [Leakage(share=0.5), Leakage(share=0.2)])
    assert twice.source.continuous == pytest.approx(0.6, rel=1e-15)
    # A random force has nothing left that could leak.
    random = chain(oscillator.system(), rig_with("hann", "random", 101), [Leakage(share=0.5)])
    assert random.source.continuous == 1.0


def test_it_is_suspected_where_noise_that_is_fitted_hides_the_drop() -> None:
    # Free noise of the force is fitted to the low coherence at resonances: there too little of it is left.
    freq = np.linspace(2.0, 800.0, 41)
    near = np.exp(-(((freq - 300.0) / 20.0) ** 2))[:, None]
    evidence = Evidence(
        freq=freq,
        outputs=(Dof(1, "Y"),),
        drive=Dof(1, "Y"),
        frf=near.astype(complex),
        force=None,
        response=None,
        coherence_drop=-1e-3 * near,
        weight=np.ones((41, 1)),
        mode_frequency=np.array([300.0]),
        frequency_shift=np.zeros(1),
        response_amplitude=np.ones((1, 1)),
    )
    assert Leakage.signature(evidence) > DIAGNOSIS.least_suspicion


def test_it_has_no_place_where_nothing_repeats_as_declared() -> None:
    places = [
        Leakage.places(oscillator.system(), rig_with("hann", kind, 101)) for kind in ("random", "chirp")
    ]
    assert [len(each) for each in places] == [0, 1]
