"""A hardening spring on a mass, held against closed forms of the Duffing oscillator under white force."""

import json

import numpy as np
import pytest
from scipy.special import gamma

from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.fe.structure import Structure
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup
from modallab.store.plain import from_plain, to_plain
from tests import oscillator
from tests.oscillator import DAMPING, FREQUENCY, MASS, STIFFNESS, TIP


def hardened(setup: RigSetup, share: float) -> Chain:
    """The oscillator with a cubic spring that adds, to first order, this share to its stiffness."""
    linear = oscillator.mean_square(oscillator.density(setup))
    return chain(oscillator.system(), setup, [CubicStiffness(TIP, share * STIFFNESS / (3 * linear))])


def periodic(**analyser: float) -> RigSetup:
    """A rig whose lines, many to a half-power bandwidth, see what they see without a window."""
    return oscillator.rig_at_tip(excitation="periodic_random", window="rectangular", **analyser)


@pytest.mark.parametrize(
    "setup", [oscillator.rig_at_tip(), periodic(n_lines=5401)], ids=["random", "periodic"]
)
def test_a_little_raises_the_resonance_by_half_of_what_it_adds_to_the_stiffness(setup: RigSetup) -> None:
    """3 k_3 s^2 / (2 k) with s^2 = G / (4 c k): Caughey (1963), J. Acoust. Soc. Am. 35, 1706-1711."""
    share = 1e-4
    found = hardened(setup, share).poles()[0][0, 0] / FREQUENCY - 1
    # The next order is the share itself; the motion lacks 2e-6 of what the force has above the band.
    assert found == pytest.approx(share / 2, rel=3e-4)


@pytest.mark.parametrize("n_lines", [541, 33])  # a half-power bandwidth is 0.5 lines, or 0.03
@pytest.mark.parametrize("share", [0.01, 0.3, 5.0])
def test_much_of_it_moves_less_and_so_adds_less(share: float, n_lines: int) -> None:
    """k' = k + 3 k_3 G / (4 c k'): a quadratic equation."""
    found = hardened(oscillator.rig_at_tip(n_lines=n_lines), share).poles()[0][0, 0]
    stiffness = (1 + np.sqrt(1 + 4 * share)) / 2
    # what the force lacks above the band: 0.4 zeta (f'/f_max)^3, 8e-6 of the mean square of the stiffest
    assert found == pytest.approx(FREQUENCY * np.sqrt(stiffness), rel=3e-6)


def test_the_resonance_rises_with_the_mean_square_of_the_force() -> None:
    spring = CubicStiffness(TIP, 1e-3 * STIFFNESS / (3 * oscillator.mean_square(1.0 / 540.0)))
    levels = np.array([0.1, 0.2, 0.4])
    shifts = [
        chain(oscillator.system(), oscillator.rig_at_tip(level), [spring]).poles()[0][0, 0] / FREQUENCY - 1
        for level in levels
    ]
    np.testing.assert_allclose(shifts, 5e-4 * levels**2, rtol=1e-3)  # next order: the greatest share, 1.6e-4


def test_a_spring_of_nothing_but_the_cube_is_as_far_off_the_exact_law_as_known() -> None:
    """Of x'' + c x' + k_3 x^3 the density is exp(-x^4 c k_3 / G) exactly, so that the mean square is
    2 sqrt(D) Gamma(3/4)/Gamma(1/4), D = G/(4 c k_3), and its straight line has sqrt(D/3): 14.6 % less.
    Roberts and Spanos, Random Vibration and Statistical Linearization (1990), chapter 5."""
    setup = periodic(frequency_max=1620.0, n_lines=20001)
    share = 1e4
    bench = hardened(setup, share)
    k3 = share * STIFFNESS / (3 * oscillator.mean_square(oscillator.density(setup)))
    d = oscillator.density(setup) / (4 * DAMPING * k3)
    exact = 2 * np.sqrt(d) * gamma(0.75) / gamma(0.25)
    # What is left of the straight spring, 1/sqrt(share), takes half of that: 0.5 %.
    assert bench.runs[0].local_forces[0].rms ** 2 / exact == pytest.approx(1 - 0.146, rel=6e-3)


def test_coherence_drops_at_resonance_and_at_three_times_it_as_the_cube_of_a_narrow_band_says() -> None:
    """What is left of the cube has the correlation 6 k_3^2 s^6 rho^3. Of rho = e^(-a t) cos(w t), a = c/2m,
    that is 3/4 cos(w t) + 1/4 cos(3 w t) under e^(-3 a t): densities 3 k_3^2 s^6/a at w, a third at 3 w.
    They act where the force does: coherence is one over one and their share of the force."""
    setup, share = periodic(n_lines=5401), 0.002
    bench = hardened(setup, share)
    density = oscillator.density(setup)
    linear, a = oscillator.mean_square(density), DAMPING / (2 * MASS)
    k3 = share * STIFFNESS / (3 * linear)
    noise = 3 * k3**2 * (linear / (1 + share)) ** 3 / a
    g2 = coherence(expected_spectra(bench))[0, :, 0]
    freq, once = setup.analyser.freq, bench.poles()[0][0, 0]
    for frequency, left in ((once, noise), (3 * once, noise / 3)):
        # as wide as the product of three is: half width 3 a
        offset = 2 * np.pi * (freq - frequency) / (3 * a)
        near = np.abs(offset) < 1
        wanted = 1 / (1 + left / density / (1 + offset[near] ** 2))
        # the sine that comes with the cosine of rho is zeta of it, three times that in rho^3: 1.5 %
        np.testing.assert_allclose(1 - g2[near], 1 - wanted, rtol=0.02)
    assert 1 - g2.min() == pytest.approx(noise / (density + noise), rel=0.01)


@pytest.mark.parametrize("share", [0.002, 0.3])
def test_h1_is_the_frf_of_the_mass_on_a_stiffer_spring_that_remembers(share: float) -> None:
    """To second order the residual holds -18 k_3^2 R^2 g against the motion. With R = s^2 e^(-a t) cos(w t)
    and g = e^(-a t) sin(w t) / (m w) the sines of w and of 3 w are left of it, under e^(-3 a t): with
    e = 3 k_3 s^2 that is e^2/(2 m) (1/((3 a + i u)^2 + w^2) + 3/((3 a + i u)^2 + 9 w^2)) at u rad/s."""
    setup = periodic(n_lines=5401)
    omega = 2 * np.pi * setup.analyser.freq[1:]
    stiffness = STIFFNESS * (1 + np.sqrt(1 + 4 * share)) / 2
    found = ESTIMATORS["h1"](expected_spectra(hardened(setup, share)))[0, 1:, 0, 0]
    held = -(omega**2) / found - (stiffness - omega**2 * MASS + 1j * omega * DAMPING)
    a, w = DAMPING / (2 * MASS), np.sqrt(stiffness / MASS)
    parts = [n / ((3 * a + 1j * omega) ** 2 + (n * w) ** 2) for n in (1, 3)]
    wanted = -((stiffness - STIFFNESS) ** 2) / (2 * MASS) * (parts[0] + parts[1])
    # the sine that comes with the cosine of rho is zeta of it, twice in rho^2, and the same in g: 1.5 %
    assert np.abs(held - wanted).max() < 0.02 * np.abs(wanted).max()
    near = np.abs(omega / w - 1) < 3 * a / w
    assert (held.imag[near] > 0).all(), "it takes power where the mass moves most"


def test_a_resonance_that_is_mostly_distorted_moves_no_more_than_the_force_can_make_it() -> None:
    """White force puts G/(4 m) into a mass, whatever springs and residuals do with it: its mean square is
    that of the straight line, and up to 14.6 % more by the exact law (see the pure cube above)."""
    setup = periodic(n_lines=5401)
    bench = hardened(setup, 0.3)
    spectra = expected_spectra(bench)
    omega = 2 * np.pi * setup.analyser.freq[1:]
    moved = spectra.xx[0, 1:, 0] / omega**4
    loose = (1 - coherence(spectra)[0, 1:, 0]) * moved
    assert loose.sum() > 0.5 * moved.sum(), "hardly distorted: nothing was shown"
    assert 1 < moved.sum() * setup.analyser.spacing / bench.runs[0].local_forces[0].rms ** 2 < 1.146


def test_a_model_that_has_it_comes_back_from_a_file_and_measures_the_same() -> None:
    effect = CubicStiffness(TIP, 3.7e11)
    model = effect.added_to(oscillator.structure())
    assert model.effects == (effect.spec,)
    tree, arrays = to_plain(model)
    again = from_plain(Structure, json.loads(json.dumps(tree)), arrays)
    assert again.effects == model.effects
    setup = oscillator.rig_at_tip(n_lines=101)
    one, other, bare = (
        measure(structure, setup, route=Route.EXPECTED, rng=np.random.default_rng(0)).frf.values
        for structure in (model, again, oscillator.structure())
    )
    assert one.tobytes() == other.tobytes()
    assert np.abs(one / bare - 1)[1:].max() > 0.01
