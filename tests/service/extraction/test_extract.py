from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.options import GlobalOptions
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from tests.service.extraction.conftest import Beam

KINDS = sorted(EXTRACTION_METHODS)
EXACT = [kind for kind in KINDS if EXTRACTION_METHODS[kind].exact]
CLEAN = 1e6  # averages: as good as no random error


def noise_of(frf: FrfSet, seed: int, averages: float, ratio: float = 1e-5) -> tuple[FrfSet, FloatArray]:
    """Return FRFs with the random error of 1 % noise on the force, `ratio` on the response, and coherence."""
    rng = np.random.default_rng(seed)
    power = np.abs(frf.values) ** 2
    coherence = 1 / (1.01 * (1 + ratio * power.mean(axis=0) / np.maximum(power, 1e-30)))
    error = np.sqrt((1 - coherence) / (2 * averages * np.maximum(coherence, 1e-12)))
    shape = frf.values.shape
    wobble = error * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return replace(frf, values=frf.values * (1 + wobble)), coherence[:, :, 0]


@pytest.mark.parametrize("kind", EXACT)
def test_the_modes_of_clean_data_are_the_exact_ones(kind: str, plain_beam: Beam, freq: FloatArray) -> None:
    model = extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, method=kind)
    # left over: how modes above 800 Hz and rigid bodies differ from a constant over a window
    np.testing.assert_allclose(model.frequencies, plain_beam.frequencies[:, 0], rtol=2e-6)
    # mode 1 is 0.1 line wide: what lies beside its nearest lines weighs ten times more
    np.testing.assert_allclose(model.loss_factors, plain_beam.loss_factors[:, 0], rtol=4e-3)
    np.testing.assert_allclose(model.loss_factors[1:], plain_beam.loss_factors[1:, 0], rtol=5e-4)
    exact = plain_beam.constants / np.sqrt(plain_beam.constants[:, :1])
    off = np.abs(model.shapes.T - exact).max(axis=1) / np.abs(exact).max(axis=1)
    assert off.max() < 3e-3


def test_peaks_are_picked_to_half_a_line_and_look_too_damped(plain_beam: Beam, freq: FloatArray) -> None:
    model = extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, method="peak_picking")
    exact = plain_beam.frequencies[:, 0]
    assert np.abs(model.frequencies - exact).max() <= 1.0  # Hz, half a line
    # bandwidths of 0.1 to 1.9 lines: the narrow ones look as wide as a line
    assert model.loss_factors[0] > 5 * plain_beam.loss_factors[0, 0]
    assert (model.loss_factors > plain_beam.loss_factors[:, 0]).all()


@pytest.mark.parametrize("kind", EXACT)
def test_each_window_follows_its_own_loaded_structure(kind: str, roving_beam: Beam, freq: FloatArray) -> None:
    model = extract(roving_beam.frf(freq), coherence=None, averages=CLEAN, method=kind)
    # mode 8 wanders over 4.4 Hz at 2 Hz a line and is 3.8 Hz wide
    assert np.ptp(roving_beam.frequencies[7]) > 4
    assert model.fitted_frequency is not None
    np.testing.assert_allclose(model.fitted_frequency, roving_beam.frequencies, atol=3e-3)
    for mode, exact in zip(model.modes, roving_beam.frequencies, strict=True):
        assert mode.frequency_spread is not None
        spread = mode.frequency_spread
        found = [spread.min, spread.max, spread.mean, spread.sd]
        # 0.01 Hz: a tenth of the last printed digit of the thesis's table 5.4
        np.testing.assert_allclose(
            found, [exact.min(), exact.max(), exact.mean(), exact.std(ddof=1)], atol=0.01
        )
        assert spread.n == 11


@pytest.mark.parametrize("kind", EXACT)
def test_noise_moves_the_means_by_no_more_than_their_standard_errors(
    kind: str, roving_beam: Beam, freq: FloatArray
) -> None:
    scores = []
    for seed in range(5):
        frf, coherence = noise_of(roving_beam.frf(freq), seed, averages=100)
        model = extract(frf, coherence=coherence, averages=100, method=kind)
        for m, mode in enumerate(model.modes):
            assert model.fitted_frequency is not None
            used = [f"{dof}" not in " ".join(mode.flags) for dof in model.dofs]
            frequency = roving_beam.frequencies[m][used].mean()
            loss_factor = roving_beam.loss_factors[m][used].mean()
            scores.append((mode.frequency - frequency) / mode.standard_errors["frequency"])
            scores.append((mode.loss_factor - loss_factor) / mode.standard_errors["loss_factor"])
    # 80 standard scores: their rms is known to 8 %; errors widened by the misfit bring it below 1
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.25


def test_shape_errors_are_the_scatter_of_repeated_tests(plain_beam: Beam, freq: FloatArray) -> None:
    models = []
    for seed in range(12):
        frf, coherence = noise_of(plain_beam.frf(freq), seed, averages=100)
        models.append(extract(frf, coherence=coherence, averages=100))
    for m in range(8):
        shapes = np.array([model.modes[m].shape for model in models])
        stated = np.array([model.modes[m].shape_errors for model in models]).mean(axis=0)
        scatter = np.sqrt((np.abs(shapes - shapes.mean(axis=0)) ** 2).sum(axis=0) / 11 / 2)
        # 12 tests of complex numbers give each scatter to 15 %, their mean over 11 DoFs to 5 %
        assert (scatter / stated).mean() == pytest.approx(1.0, abs=0.3)


def test_an_frf_at_a_node_says_so_and_does_not_reach_the_mean(plain_beam: Beam, freq: FloatArray) -> None:
    frf, coherence = noise_of(plain_beam.frf(freq), 3, averages=100)
    model = extract(frf, coherence=coherence, averages=100)
    for m in (1, 3, 5, 7):  # antisymmetric: still in the middle, node 11
        assert "node: 11:+Y" in model.modes[m].flags
        spread = model.modes[m].frequency_spread
        assert spread is not None
        assert spread.sd < 0.1  # Hz; noise alone would scatter over a window of 16 Hz
        assert abs(model.modes[m].shape[5]) < 0.05 * np.abs(model.modes[m].shape).max()


def test_an_frf_of_another_structure_is_an_outlier(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    values = frf.values.copy()
    stretched = np.interp(freq, freq * 1.004, values[:, 4, 0].real) + 1j * np.interp(
        freq, freq * 1.004, values[:, 4, 0].imag
    )
    values[:, 4, 0] = stretched
    model = extract(replace(frf, values=values), coherence=None, averages=CLEAN)
    assert any("9:+Y" in flag for flag in model.modes[6].flags)
    # 587.5 Hz; the stranger's 589.9 Hz would move the mean of eleven by 0.2 Hz
    assert model.frequencies[6] == pytest.approx(plain_beam.frequencies[6, 0], abs=0.01)


def test_a_band_without_a_mode_is_named(plain_beam: Beam, freq: FloatArray) -> None:
    clean = plain_beam.frf(freq)
    frf, coherence = noise_of(clean, 3, averages=100)
    for lower, upper in ((90.0, 110.0), (340.0, 400.0), (650.0, 700.0)):
        with pytest.raises(NoModeInBandError, match=f"{lower:g} and {upper:g} Hz"):
            extract(clean, coherence=None, averages=CLEAN, bands=[(20, 26), (lower, upper)])
        with pytest.raises(NoModeInBandError, match=f"{lower:g} and {upper:g} Hz"):
            extract(frf, coherence=coherence, averages=100, bands=[(20, 26), (lower, upper)])


def test_bands_of_the_user_hold_one_mode_each(plain_beam: Beam, freq: FloatArray) -> None:
    bands = [(120.0, 136.0), (20.0, 26.0)]
    model = extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, bands=bands)
    # mode 1 from the four lines of its band; the modes left out are but a constant here
    np.testing.assert_allclose(model.frequencies, plain_beam.frequencies[[0, 2], 0], rtol=1e-3)


@pytest.mark.parametrize("bands", [[(20.0, 21.0)], [(30.0, 20.0)], [(900.0, 950.0)]])
def test_a_band_of_too_few_lines_is_refused(
    bands: list[tuple[float, float]], plain_beam: Beam, freq: FloatArray
) -> None:
    with pytest.raises(InvalidInputError, match="band 0"):
        extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, bands=bands)


@pytest.mark.parametrize("value", [0.0, 2.0 - 1.0j])
def test_responses_without_shape_hold_no_mode(value: complex, plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    flat = FrfSet(freq, np.full(frf.values.shape, value), frf.outputs, frf.inputs, FrfKind.INERTANCE)
    with pytest.raises(NoModeInBandError):
        extract(flat, coherence=None, averages=CLEAN)


@pytest.mark.parametrize("method", ["dobson", "lscf"])
def test_one_dead_channel_is_flagged_and_the_others_speak(
    method: str, plain_beam: Beam, freq: FloatArray
) -> None:
    frf = plain_beam.frf(freq)
    values = frf.values.copy()
    values[:, 3, 0] = 0
    model = extract(replace(frf, values=values), coherence=None, averages=CLEAN, method=method)
    np.testing.assert_allclose(model.frequencies, plain_beam.frequencies[:, 0], rtol=2e-6)  # as with all
    assert all(np.isfinite(mode.shape).all() for mode in model.modes)
    assert all("7:+Y" in " ".join(mode.flags) for mode in model.modes)


def test_incoherent_lines_are_not_listened_to(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    hum = np.isclose(freq, 126.0)
    values, coherence = frf.values.copy(), np.ones((401, 11))
    values[hum] *= 5
    coherence[hum] = 0
    model = extract(replace(frf, values=values), coherence=coherence, averages=CLEAN)
    assert model.frequencies[2] == pytest.approx(plain_beam.frequencies[2, 0], rel=1e-5)  # as without hum


def test_a_roving_hammer_gives_the_modes_of_a_roving_accelerometer(
    plain_beam: Beam, freq: FloatArray
) -> None:
    frf = plain_beam.frf(freq)
    hammer = FrfSet(freq, frf.values.swapaxes(1, 2), frf.inputs, frf.outputs, frf.kind)
    there = extract(frf, coherence=np.ones((401, 11)), averages=CLEAN)
    back = extract(hammer, coherence=np.ones((401, 1, 11)), averages=CLEAN)
    np.testing.assert_array_equal(there.shapes, back.shapes)
    assert back.dofs == frf.outputs


def test_signs_of_drive_and_response_turn_components_not_the_mode(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    signs = np.array([-1, 1, -1, 1, 1, 1, 1, 1, 1, 1, -1])
    turned = FrfSet(
        freq,
        -frf.values * signs[None, :, None],
        tuple(Dof(d.node, d.direction, int(s)) for d, s in zip(frf.outputs, signs, strict=True)),
        (Dof(1, "Y", -1),),
        frf.kind,
    )
    straight = extract(frf, coherence=None, averages=CLEAN)
    model = extract(turned, coherence=None, averages=CLEAN)
    physical = model.shapes * signs[:, None]
    # the drive component points along the drive: here to -Y
    np.testing.assert_allclose(physical, -straight.shapes, rtol=1e-9)  # rounding
    assert not any("wrong sign" in flag for mode in model.modes for flag in mode.flags)


def test_without_a_drive_point_response_shapes_are_not_mass_normalised(
    plain_beam: Beam, freq: FloatArray
) -> None:
    frf = plain_beam.frf(freq)
    part = FrfSet(freq, frf.values[:, 1:], frf.outputs[1:], frf.inputs, frf.kind)
    model = extract(part, coherence=None, averages=CLEAN)
    assert model.normalisation == "none"
    assert "no response at the drive point 1:+Y" in " ".join(model.notes)
    assert np.abs(model.shapes).max(axis=0) == pytest.approx(1.0)


def test_fewer_modes_than_asked_for_are_noted_and_more_are_cut(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    assert "12 modes requested, 8 found" in extract(frf, coherence=None, averages=CLEAN, n_modes=12).notes
    model: ModalModel = extract(frf, coherence=None, averages=CLEAN, n_modes=3)
    assert len(model.modes) == 3


def test_inputs_that_do_not_fit_are_named(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    with pytest.raises(InvalidInputError, match="coherence does not fit"):
        extract(frf, coherence=np.ones((400, 11)), averages=100)
    with pytest.raises(InvalidInputError, match="from 0 to 1"):
        extract(frf, coherence=np.full((401, 11), np.nan), averages=100)
    with pytest.raises(InvalidInputError, match="averages"):
        extract(frf, coherence=None, averages=0)
    with pytest.raises(InvalidInputError, match="no extraction method"):
        extract(frf, coherence=None, averages=100, method="guess")
    with pytest.raises(InvalidInputError, match="at least one mode"):
        extract(frf, coherence=None, averages=100, n_modes=0)
    with pytest.raises(InvalidInputError, match="too few lines"):
        extract(frf.between(0, 6), coherence=None, averages=100)
    square = FrfSet(freq, np.ones((401, 2, 2), complex), frf.outputs[:2], frf.outputs[:2], frf.kind)
    with pytest.raises(InvalidInputError, match="coherence does not fit"):
        extract(square, coherence=np.ones((401, 2, 1)), averages=100)


@pytest.mark.parametrize("seed", range(12))
def test_whatever_comes_in_there_is_an_answer_or_a_named_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_freq, n_out = int(rng.choice([5, 20, 101])), int(rng.choice([1, 3]))
    freq = np.linspace(3.0, 300.0, n_freq)
    noise = rng.standard_normal((n_freq, n_out)) + 1j * rng.standard_normal((n_freq, n_out))
    spike = np.zeros((n_freq, n_out), complex)
    spike[n_freq // 2] = 1.0
    undamped = 1 / (4e5 + 1e-9 - (2 * np.pi * freq[:, None]) ** 2 * rng.standard_normal(n_out))
    coherence = rng.uniform(0, 1, (n_freq, n_out))
    for values in (noise, spike, np.cumsum(noise, axis=0), np.round(noise), undamped, 1e200 * noise):
        dofs = tuple(Dof(node, "Y") for node in range(1, n_out + 1))
        frf = FrfSet(freq, np.asarray(values, complex)[:, :, None], dofs, dofs[:1], FrfKind.INERTANCE)
        leakage = (
            WindowLeakage.from_window(np.hanning(513)[:512], "h1", source_mass=1.0) if seed % 2 else None
        )
        for kind in KINDS:
            try:
                model = extract(frf, coherence=coherence, averages=10, method=kind, leakage=leakage)
            except (InvalidInputError, NoModeInBandError):
                continue
            assert np.isfinite(model.shapes).all()
            assert np.isfinite(model.frequencies).all()
            assert all(np.isfinite(list(mode.standard_errors.values())).all() for mode in model.modes)


def test_an_option_that_a_method_lacks_is_refused_and_not_ignored(plain_beam: Beam, freq: FloatArray) -> None:
    with pytest.raises(InvalidInputError, match="dobson has no option 'max_order'"):
        extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, options=GlobalOptions(max_order=20))
