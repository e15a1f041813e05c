"""Two shakers at once, end to end: exact FRFs, their scatter, reciprocity, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence
from modallab.estimation.condition import input_condition
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.receptance import receptance
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra, noise_free, with_noise
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure, measurement_of
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra
from modallab.rig.wishart_forces import wishart_of_several_forces
from tests.rigs import beam_system, dofs, steel_beam

DRIVES, RESPONSES = dofs(1, 16), dofs(1, 5, 11, 16, 21)
NOISE = Noise(1e-3, 1e-4)
ARMATURES = Exciter(armature_mass=0.05)
H1 = ESTIMATORS["h1"]


def two_shakers(
    excitation: str = "periodic_random",
    noise: Noise | None = None,
    exciter: Exciter = ARMATURES,
    roving: bool = False,
    **analyser: object,
) -> RigSetup:
    return RigSetup(
        DRIVES,
        RESPONSES,
        exciter=exciter,
        accelerometers=Accelerometers(roving=roving),
        noise=noise or Noise(),
        analyser=Analyser(excitation=ExcitationSetting(excitation), **analyser),  # type: ignore[arg-type]
    )


def bench(**settings: object) -> Chain:
    return chain(beam_system(), two_shakers(**settings))  # type: ignore[arg-type]


def frf_scatter(spectra: CrossSpectra) -> FloatArray:
    """Expected |dH|^2 of H1, (n_run, n_freq, n_out, n_in): G_ff^-1 times the unexplained over n - n_in."""
    n_in = spectra.ff.shape[-1]
    own = np.linalg.inv(spectra.ff)[..., np.arange(n_in), np.arange(n_in)].real
    unexplained = spectra.xx * (1 - coherence(spectra))
    return np.asarray(unexplained[..., None] * own[:, :, None] / (spectra.averages - n_in))


def simulated(whole: CrossSpectra, line: int, n: int, n_tests: int, seed: int) -> CrossSpectra:
    """Averages of n records, record by record: forces of the expected G_ff, responses by H1, and the rest."""
    rng = np.random.default_rng(seed)

    def gauss(*shape: int) -> ComplexArray:
        pair = rng.standard_normal((2, *shape))
        return np.asarray((pair[0] + 1j * pair[1]) / np.sqrt(2))

    h, ff = H1(whole)[0, line], whole.ff[0, line]
    n_out, n_in = h.shape
    values, vectors = np.linalg.eigh(ff.T)  # E[F F^H], a root that is not triangular
    forces = gauss(n_tests, n, n_in) @ (np.sqrt(values)[:, None] * vectors.T)
    unexplained = (whole.xx * (1 - coherence(whole)))[0, line]
    responses = forces @ h.T + np.sqrt(unexplained) * gauss(n_tests, n, n_out)
    back = forces.conj().swapaxes(1, 2)
    return CrossSpectra(
        whole.freq[line : line + 1],
        (back @ forces)[:, None] / n,
        (back @ responses)[:, None] / n,
        (np.abs(responses) ** 2).mean(axis=1)[:, None],
        n,
    )


def test_without_noise_h1_is_the_frf_of_the_bare_structure_whatever_the_exciters_take() -> None:
    whole = expected_spectra(bench())
    system = beam_system()
    left, right = system.selection(RESPONSES), system.selection(DRIVES)
    alpha = receptance(system, whole.freq[1:], left, right)
    wanted = -((2 * np.pi * whole.freq[1:]) ** 2)[:, None, None] * alpha
    # rounding, 1e-16, of responses 1e5 times larger at resonances, times the condition of G_ff, up to 1e2
    np.testing.assert_allclose(H1(whole)[0, 1:], wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())
    np.testing.assert_allclose(coherence(whole), 1.0, rtol=1e-9)
    assert np.abs(whole.ff[0, :, 0, 1]).max() > 0.1 * whole.ff[0, :, 0, 0].real.max()  # they feel each other


@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
def test_frfs_between_the_two_drives_are_reciprocal(excitation: str) -> None:
    h = H1(expected_spectra(bench(excitation=excitation, n_lines=1601)))[0]
    there, back = h[1:, 0, 1], h[1:, 3, 0]
    rtol = 1e-9 if excitation == "periodic_random" else 0.05  # leakage at 0.5 Hz a line
    np.testing.assert_allclose(there, back, rtol=rtol, atol=rtol * np.abs(there).max())


@pytest.mark.parametrize(("excitation", "roving"), [("periodic_random", False), ("random", True)])
def test_records_and_expected_spectra_agree_within_their_random_error(excitation: str, roving: bool) -> None:
    settings = {"excitation": excitation, "noise": NOISE, "roving": roving}
    whole = bench(**settings, window="hann", averages=300, n_lines=201)
    expected, sampled = expected_spectra(whole), sampled_spectra(whole, np.random.default_rng(2), silent)
    apart = np.abs(H1(sampled) - H1(expected)) ** 2 / frf_scatter(expected)
    # |dH|^2 over its mean is exponential: 1 in 1,100 beyond 7; neighbouring lines are tied
    assert (apart < 7)[:, 1:].mean() >= 0.99
    assert np.isclose(apart[:, 1:].mean(), 1, atol=0.1)
    # 0.997 of a normal scatter; resonances much narrower than a line remember the record before
    power = np.abs(sampled.xx / expected.xx - 1) < 3 / np.sqrt(300)
    force = np.abs(sampled.ff.diagonal(axis1=2, axis2=3) / expected.ff.diagonal(axis1=2, axis2=3) - 1)
    assert power[:, 1:].mean() >= 0.97
    assert (force < 3 / np.sqrt(300))[:, 1:].mean() >= 0.99


def test_drawn_spectra_are_right_in_the_mean_and_their_frfs_scatter_as_they_should() -> None:
    whole = expected_spectra(bench(noise=Noise(0.1, 0.1), averages=30, n_lines=17))
    n_tests = 4000
    drawn = wishart_spectra(whole, np.random.default_rng(3), n_tests)
    assert drawn.ff.shape == (n_tests, 17, 2, 2)
    for found, wanted in ((drawn.ff, whole.ff), (drawn.fx, whole.fx), (drawn.xx, whole.xx)):
        mean, size = found.mean(axis=0), found.std(axis=0) / np.sqrt(n_tests)
        assert (np.abs(mean - wanted[0]) < 5 * size + 1e-12 * np.abs(wanted[0]).max()).all()
    ratio = np.abs(H1(drawn) - H1(whole)) ** 2 / frf_scatter(whole)
    # Exact for the Wishart law: E[W^-1] = n/(n - n_in) G_ff^-1. Means of 4,000 nearly exponential numbers,
    # 160 of them: five standard errors.
    np.testing.assert_allclose(ratio[:, 1:].mean(axis=0), 1, atol=5 * 1.2 / np.sqrt(n_tests))
    np.testing.assert_allclose(drawn.ff, drawn.ff.conj().swapaxes(2, 3), rtol=1e-12)  # rounding


@pytest.mark.parametrize("averages", [3, 10])
def test_few_averages_scatter_as_records_drawn_one_by_one(averages: int) -> None:
    whole = expected_spectra(bench(noise=Noise(0.1, 0.3), averages=averages, n_lines=17))
    n_tests, line = 4000, 5
    drawn = wishart_spectra(whole, np.random.default_rng(4), n_tests)
    wanted = simulated(whole, line, averages, n_tests, seed=5)
    both = ((drawn, line), (wanted, 0))
    pairs = {
        "multiple coherence": [coherence(s)[:, i, 2] for s, i in both],
        "|H|": [np.abs(H1(s))[:, i, 2, 1] for s, i in both],
        "G_12": [s.ff[:, i, 0, 1].imag for s, i in both],
        "condition": [input_condition(s)[:, i] for s, i in both],
        "G_xx": [s.xx[:, i, 4] for s, i in both],
    }
    for name, (found, other) in pairs.items():
        assert kstest(found, other).pvalue > 1e-3, name  # five numbers, one seed each


def test_multiple_coherence_of_nothing_is_a_beta_variable() -> None:
    n, n_in, n_tests = 12, 3, 5000
    nothing = CrossSpectra(
        np.array([0.0, 1.0]),
        np.tile(np.eye(n_in, dtype=complex), (1, 2, 1, 1)),
        np.zeros((1, 2, n_in, 1), complex),
        np.ones((1, 2, 1)),
        n,
    )
    g2 = coherence(wishart_spectra(nothing, np.random.default_rng(6), n_tests))[..., 0]
    # Goodman (1963): the forces explain Beta(n_in, n - n_in) of what has nothing to do with them; at 0 Hz,
    # where all is real, half as many of each.
    assert kstest(g2[:, 1], "beta", (n_in, n - n_in)).pvalue > 1e-3
    assert kstest(g2[:, 0], "beta", (n_in / 2, (n - n_in) / 2)).pvalue > 1e-3


def test_at_zero_hertz_spectra_are_real() -> None:
    whole = CrossSpectra(
        np.array([0.0, 1.0]),
        np.tile(np.array([[2.0, 1.0], [1.0, 3.0]], complex), (1, 2, 1, 1)),
        np.full((1, 2, 2, 1), 0.5 + 0j),
        np.ones((1, 2, 1)),
        10,
    )
    drawn = wishart_spectra(whole, np.random.default_rng(7), 3)
    assert not drawn.fx[:, 0].imag.any()
    assert not drawn.ff[:, 0].imag.any()
    assert drawn.fx[:, 1].imag.all()


def test_one_force_by_the_law_of_several_scatters_as_by_its_own() -> None:
    setup = RigSetup(dofs(1), dofs(1, 7), noise=Noise(0.1, 0.1), analyser=Analyser(n_lines=9, averages=8))
    whole = expected_spectra(chain(beam_system(), setup))
    one = wishart_spectra(whole, np.random.default_rng(8), 4000)
    other = wishart_of_several_forces(whole, np.random.default_rng(9), 4000)
    for line in (0, 4):
        for found, wanted in ((one.xx, other.xx), (one.ff.real[..., 0], other.ff.real[..., 0])):
            assert kstest(found[:, line, 0], wanted[:, line, 0]).pvalue > 1e-3
        assert kstest(coherence(one)[:, line, 1], coherence(other)[:, line, 1]).pvalue > 1e-3


def test_the_same_seed_draws_and_samples_the_same_bytes() -> None:
    setup = two_shakers(noise=NOISE, n_lines=65, averages=8)
    for route in (Route.DRAWN, Route.SAMPLED):
        a, b, c = (
            measure(steel_beam(), setup, route=route, rng=np.random.default_rng(seed)) for seed in (1, 1, 2)
        )
        assert a.frf.values.tobytes() == b.frf.values.tobytes() != c.frf.values.tobytes()


def test_a_measurement_says_how_well_the_forces_are_told_apart() -> None:
    rng = np.random.default_rng(1)
    plain = measure(steel_beam(), two_shakers(exciter=Exciter()), route=Route.EXPECTED, rng=rng)
    assert plain.frf.values.shape == (401, 5, 2)
    assert plain.coherence is not None
    assert plain.coherence.shape == (401, 5)
    assert plain.input_condition is not None
    # equal forces that have nothing in common and take no notice of the structure
    np.testing.assert_allclose(plain.input_condition, 1.0, rtol=1e-9)
    half = two_shakers(exciter=Exciter(armature_mass=0.5))
    heavy = measure(steel_beam(), half, route=Route.EXPECTED, rng=rng)
    assert heavy.input_condition is not None
    resonance = heavy.input_condition[np.abs(heavy.frf.freq - 22.0) < 6].max()
    assert resonance > 10  # both armatures feel the first mode, and take the same force out of both
    one = RigSetup(DRIVES[:1], RESPONSES)
    assert measure(steel_beam(), one, route=Route.EXPECTED, rng=rng).input_condition is None


def test_of_a_roving_test_the_worst_run_counts() -> None:
    setup = two_shakers(roving=True, noise=NOISE, averages=20, n_lines=33)
    roved = measure(steel_beam(), setup, route=Route.DRAWN, rng=np.random.default_rng(2))
    spectra = wishart_spectra(expected_spectra(chain(beam_system(), setup)), np.random.default_rng(2))
    assert spectra.ff.shape[0] == len(RESPONSES)
    assert roved.input_condition is not None
    np.testing.assert_allclose(roved.input_condition, input_condition(spectra).max(axis=0), rtol=1e-12)


@pytest.mark.parametrize("estimator", ["h2", "hv"])
def test_an_estimator_for_one_force_is_refused_when_the_rig_is_declared(estimator: str) -> None:
    with pytest.raises(InvalidInputError, match="one force") as caught:
        two_shakers(estimator=estimator)
    assert caught.value.context["field"] == "estimator"
    assert caught.value.context["allowed"] == ["h1"]
    hammer = RigSetup(DRIVES, RESPONSES, exciter=Exciter("hammer"), analyser=Analyser(estimator=estimator))
    assert len(hammer.acquisition_runs) == 2  # one force after the other


@pytest.mark.parametrize(("averages", "overlap"), [(1, 0.0), (3, 0.9)])
def test_fewer_independent_averages_than_forces_are_refused(averages: int, overlap: float) -> None:
    with pytest.raises(InvalidInputError, match="averages") as caught:
        two_shakers(averages=averages, overlap=overlap)
    assert caught.value.context["field"] == "averages"


def test_as_many_averages_as_forces_explain_all() -> None:
    setup = two_shakers(averages=2, noise=Noise(0.1, 0.1), n_lines=33)
    for route in (Route.DRAWN, Route.SAMPLED):
        test = measure(steel_beam(), setup, route=route, rng=np.random.default_rng(3))
        assert test.coherence is not None
        # rounding times the condition of a G_ff of two averages, at worst 1e6
        np.testing.assert_allclose(test.coherence, 1.0, rtol=1e-6)


def test_forces_that_are_one_are_refused_by_name() -> None:
    together = CrossSpectra(
        np.array([1.0]), np.ones((1, 1, 2, 2), complex), np.ones((1, 1, 2, 1), complex), np.ones((1, 1, 1)), 9
    )
    with pytest.raises(InvalidInputError, match="not independent"):
        wishart_spectra(together, np.random.default_rng(1))
    assert input_condition(together)[0, 0] > 1e14
    setup = RigSetup(DRIVES, RESPONSES[:1], analyser=Analyser(n_lines=8))
    with pytest.raises(InvalidInputError, match="not independent") as caught:
        measurement_of(together, setup)
    assert caught.value.context["field"] == "excitation.kind"


@pytest.mark.parametrize("roving", [False, True])
def test_a_measurement_holds_the_cross_spectra_of_its_forces(roving: bool) -> None:
    setup = two_shakers(noise=NOISE, roving=roving, n_lines=101)
    test = measure(steel_beam(), setup, route=Route.DRAWN, rng=np.random.default_rng(4))
    assert test.force_cross_spectra is not None
    assert test.force_spectrum is not None
    assert test.input_condition is not None
    own = test.force_cross_spectra[..., [0, 1], [0, 1]]
    np.testing.assert_array_equal(own.real, test.force_spectrum)
    eigenvalues = np.linalg.eigvalsh(test.force_cross_spectra)
    condition = (eigenvalues[..., 1] / eigenvalues[..., 0]).max(axis=1)
    np.testing.assert_allclose(condition, test.input_condition, rtol=1e-9)  # rounding of eigenvalues
    alone = measure(
        steel_beam(), replace(setup, drives=DRIVES[:1]), route=Route.EXPECTED, rng=np.random.default_rng(4)
    )
    assert alone.force_cross_spectra is None


def test_noise_of_the_forces_is_in_all_responses_of_a_drawn_test() -> None:
    """H1 of a drawn test has the errors that noisy forces cause: in all responses alike."""
    beam, n_tests = bench(noise=Noise(0.1, 1e-3), n_lines=9, frequency_max=160.0, averages=20), 4000
    clean = noise_free(beam)
    whole, signal = with_noise(beam, clean), clean[..., :4].reshape(1, 9, 2, 2)
    drawn = wishart_spectra(whole, np.random.default_rng(10), n_tests, signal=signal)
    plain = wishart_spectra(whole, np.random.default_rng(11), n_tests)
    for part in ("ff", "fx", "xx"):
        # each spectrum alone is as before: the mean of 4000 tests of 20 averages scatters by 0.4 %
        mean, other = (getattr(s, part).mean(axis=0)[1:] for s in (drawn, plain))
        scale = np.abs(getattr(whole, part)[0, 1:]).max(axis=(1, *range(2, mean.ndim)), keepdims=True)
        np.testing.assert_allclose(mean / scale, other / scale, atol=0.02)
    np.testing.assert_allclose(
        coherence(drawn).mean(axis=0)[1:], coherence(plain).mean(axis=0)[1:], atol=0.01
    )
    for line in range(1, 9):
        h, inverse = H1(whole)[0, line], np.linalg.inv(whole.ff[0, line])
        error = (H1(drawn)[:, line] - h).reshape(n_tests, -1)
        found = error.T @ error.conj() / n_tests
        # signal of both channels less what the noisy ones explain of it, through the true FRFs
        true = np.linalg.solve(signal[0, line], whole.fx[0, line])
        hidden = signal[0, line] - signal[0, line] @ inverse @ signal[0, line]
        incoherent = (true.conj().T @ hidden @ true).T  # E[e_a conj(e_b)]
        incoherent += np.diag((whole.xx * (1 - coherence(whole)))[0, line] - np.diag(incoherent).real)
        expected = np.kron(incoherent, inverse) / (whole.averages - 2)
        size = np.sqrt(np.diag(expected).real)
        # correlations of 4000 draws scatter by 1.6 %, the variance of a ratio of averages by a little more
        np.testing.assert_allclose(found / np.outer(size, size), expected / np.outer(size, size), atol=0.1)
