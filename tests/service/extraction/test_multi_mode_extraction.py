import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.averaging.resynthesis import resynthesise
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping
from tests.service.extraction.conftest import Beam
from tests.service.extraction.six_mode_models import six_mode_model
from tests.service.extraction.test_extract import CLEAN, noise_of
from tests.synthetic import HAMMERED, HAMMERED_LOSS, PAIR, Synthetic, hammered, six_modes

METHOD = "lscf"


def scores(model: ModalModel, made: Synthetic) -> np.ndarray:
    frequency = [mode.standard_errors["frequency"] for mode in model.modes]
    loss_factor = [mode.standard_errors["loss_factor"] for mode in model.modes]
    return np.concatenate(
        [
            (model.frequencies - made.frequency) / frequency,
            (model.loss_factors - made.loss_factor) / loss_factor,
        ]
    )


@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_pair_one_bandwidth_apart_is_resolved_and_named(seed: int, measured: bool) -> None:
    made = six_modes(40, seed, lower=1.0)
    model = six_mode_model(40, seed, damping=Damping.VISCOUS, measured=measured)
    assert len(model.modes) == 6
    for m in PAIR:
        assert model.frequencies[m] == pytest.approx(made.frequency[m], rel=1e-3)
        assert model.loss_factors[m] == pytest.approx(made.loss_factor[m], rel=5e-2)
    paired = [any(flag.startswith("pair: ") for flag in mode.flags) for mode in model.modes]
    assert paired == [False, True, True, False, False, False]


def test_standard_errors_of_a_pair_cover_the_truth_where_noise_is_high() -> None:
    worst = []
    for seed in range(4):
        model = six_mode_model(30, seed, damping=Damping.VISCOUS)
        worst.append(np.abs(scores(model, six_modes(30, seed, lower=1.0))))
    # of 48 standard normal numbers one beyond 4 comes once in 300 such lots; their rms is 1 within 10 %
    assert np.max(worst) < 4
    assert np.sqrt(np.mean(np.square(worst))) == pytest.approx(1.0, abs=0.3)


def test_the_wrong_law_of_damping_moves_a_frequency_by_the_square_of_the_damping() -> None:
    made = six_modes(40, 0, lower=1.0)
    model = six_mode_model(40, damping=Damping.STRUCTURAL)
    # viscous: |H| peaks, and structural modes with it, at omega_r (1 - zeta^2) at the lowest
    np.testing.assert_allclose(model.frequencies, made.frequency, rtol=5e-4)
    np.testing.assert_allclose(model.loss_factors, made.loss_factor, rtol=2e-2)


def test_frfs_of_several_structures_are_told_from_those_of_one(
    plain_beam: Beam, roving_beam: Beam, freq: np.ndarray
) -> None:
    def warnings(beam: Beam) -> list[str]:
        noisy, coherence = noise_of(beam.frf(freq), 1, 100.0)
        model = extract(noisy, coherence=coherence, averages=100.0, method=METHOD)
        return [note for note in model.notes if "to one structure" in note]

    assert warnings(plain_beam) == []
    (warning,) = warnings(roving_beam)
    assert "at the roving accelerometer" in warning
    noisy, coherence = noise_of(roving_beam.frf(freq), 1, 100.0)
    notes = extract(noisy, coherence=coherence, averages=100.0, method=METHOD).notes
    assert any("frequency of each FRF" in note and "dobson" in note for note in notes), (
        "with what to read them instead"
    )


def test_modes_of_clean_responses_are_exact(plain_beam: Beam, freq: np.ndarray) -> None:
    model = extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, method=METHOD)
    # what lies above the range is two poles here, and of 34 modes
    np.testing.assert_allclose(model.frequencies, plain_beam.frequencies[:, 0], rtol=1e-5)
    np.testing.assert_allclose(model.loss_factors[1:], plain_beam.loss_factors[1:, 0], rtol=2e-3)
    assert model.chart is not None
    assert set(model.chart.mode.tolist()) >= set(range(1, 8))
    assert model.resynthesis_error is not None
    # mode 9, a fifth above the range, is no constant, nor are rigid bodies with damping a mass line: poles
    # stand for them, and what is left is 33 modes further above
    assert model.resynthesis_error.max() < 0.01


@pytest.mark.parametrize("n_modes", [None, 7])
def test_all_modes_and_what_bends_the_range_leave_but_noise(plain_beam: Beam, n_modes: int | None) -> None:
    freq = np.linspace(0.0, 700.0, 701)  # 7 modes, the eighth a twelfth above
    frf, coherence = noise_of(plain_beam.frf(freq), 1, averages=100)
    model = extract(frf, coherence=coherence, averages=100, method=METHOD, n_modes=n_modes)
    noise = np.sqrt(0.01 / 1.01 / 100)  # of every line: coherence 1/1.01, 100 averages
    assert model.resynthesis_error is not None
    # where an FRF shows the pole beyond strongly it is placed less surely than the modes
    assert model.resynthesis_error.max() < 3 * noise
    made = resynthesise(model, freq[1:], FrfKind.MOBILITY).values[:, :, 0]
    measured = frf.between(0.0, np.inf).to(FrfKind.MOBILITY).values[:, :, 0]
    rms = np.sqrt((np.abs(made - measured) ** 2).mean(axis=0) / (np.abs(measured) ** 2).mean(axis=0))
    np.testing.assert_allclose(rms, model.resynthesis_error, rtol=0.1)  # bias of noise, taken off first


def test_noise_moves_modes_by_their_standard_errors(plain_beam: Beam, freq: np.ndarray) -> None:
    scored = []
    exact = np.abs(plain_beam.constants)
    for seed in range(3):
        frf, coherence = noise_of(plain_beam.frf(freq), seed, averages=100)
        model = extract(frf, coherence=coherence, averages=100, method=METHOD)
        assert len(model.modes) == 8
        assert model.modal_constant is not None
        assert model.modal_constant_error is not None
        scored.append((np.abs(model.modal_constant) - exact) / model.modal_constant_error)
        for m, mode in enumerate(model.modes):
            frequency, loss_factor = plain_beam.frequencies[m, 0], plain_beam.loss_factors[m, 0]
            assert abs(mode.frequency - frequency) < 4 * mode.standard_errors["frequency"]
            assert abs(mode.loss_factor - loss_factor) < 4 * mode.standard_errors["loss_factor"]
    # 264 numbers: their rms is known to 4 %
    assert np.sqrt(np.mean(np.square(scored))) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("noisy", [True, False])
def test_one_frf_alone_gives_its_modes(noisy: bool, plain_beam: Beam, freq: np.ndarray) -> None:
    frf, coherence = noise_of(plain_beam.frf(freq), 1, averages=1e4)
    values = frf.values if noisy else plain_beam.frf(freq).values
    driven = FrfSet(freq, values[:, :1], frf.outputs[:1], frf.inputs, frf.kind)
    model = extract(driven, coherence=coherence[:, :1] if noisy else None, averages=1e4, method=METHOD)
    # random error is 0.07 % of a line: a tenth of a bandwidth of the narrowest mode would be 1e-3
    np.testing.assert_allclose(model.frequencies, plain_beam.frequencies[:, 0], rtol=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_what_spoils_the_lowest_lines_costs_no_mode(seed: int) -> None:
    freq = np.arange(0.0, 326.0)
    rng, natural = np.random.default_rng(seed), 2 * np.pi * np.array([51.52, 142.18, 278.67])
    omega2 = (2 * np.pi * freq[:, None]) ** 2
    # modes 0.05 to 0.1 lines wide, as of a light beam; no coherence was measured
    gap = natural**2 * (1 + 1j * np.array([1e-3, 7.6e-4, 3.7e-4])) - omega2
    values = (-omega2 * np.array([0.02, -0.017, 0.027]) / gap).sum(axis=1)
    values += 0.005 * (rng.standard_normal(326) + 1j * rng.standard_normal(326))
    values[1:4] += [-0.12j, 0.1, 0.08j]
    dofs = (Dof(1, "X"),)
    frf = FrfSet(freq, values[:, None, None], dofs, dofs, FrfKind.INERTANCE)
    model = extract(frf, coherence=None, averages=1.0, method=METHOD)
    for mode, exact in zip(model.modes, natural / (2 * np.pi), strict=True):
        # of nine normal numbers one beyond 4 comes once in 1,700 such lots; a line is 1 Hz
        assert abs(mode.frequency - exact) < 4 * mode.standard_errors["frequency"] < 0.2
    assert any("negative damping" in note for note in model.notes)


def test_what_noise_of_a_hammer_puts_beside_modes_bends_lines_and_is_no_mode() -> None:
    frf = hammered(0, 3)
    model = extract(frf, coherence=None, averages=100.0, method=METHOD)
    away = np.abs(model.frequencies[:, None] / HAMMERED - 1).min(axis=0)
    # up to 698.5 Hz noise is less than half of the force, and moves no mode by a tenth of its bandwidth
    assert (away[:5] < 0.1 * HAMMERED_LOSS[:5]).all()
    assert np.count_nonzero(model.frequencies < 720) == 5
    # the pole that bends the lines beside the fifth mode is listed apart, whatever tells that it is no mode
    assert any(680 < pole.frequency < 720 and pole.reason for pole in model.doubtful)
    assert any("classified as noise" in note for note in model.notes)


def test_progress_rises_in_parts_none_of_which_is_most(plain_beam: Beam, freq: np.ndarray) -> None:
    said = []
    frf, coherence = noise_of(plain_beam.frf(freq), 3, averages=100)
    extract(
        frf,
        coherence=coherence,
        averages=100,
        method=METHOD,
        progress=lambda *told: said.append(told[0]),
    )
    steps = np.diff([0.0, *said, 1.0])
    assert (steps >= 0).all()
    # rounds and steps are as many as they are: what those not needed would take is told at once
    assert steps.max() < 0.5


def test_a_band_holds_several_modes_and_one_without_is_named(plain_beam: Beam, freq: np.ndarray) -> None:
    frf, coherence = noise_of(plain_beam.frf(freq), 3, averages=100)
    model = extract(frf, coherence=coherence, averages=100, method=METHOD, bands=[(100.0, 380.0)])
    np.testing.assert_allclose(model.frequencies, plain_beam.frequencies[2:5, 0], rtol=1e-3)
    with pytest.raises(NoModeInBandError, match="340 and 400 Hz"):
        extract(frf, coherence=coherence, averages=100, method=METHOD, bands=[(340.0, 400.0)])


def test_what_wanders_outside_the_band_asked_for_is_no_matter(plain_beam: Beam, freq: np.ndarray) -> None:
    frf = plain_beam.frf(freq)
    values = frf.values.copy()
    above = freq > 300
    for j in range(1, values.shape[1]):  # as if each FRF were of a structure of its own there
        values[above, j] = np.roll(values[above, j], 2 * j, axis=0)
    spoilt = FrfSet(freq, values, frf.outputs, frf.inputs, frf.kind)
    told = [
        any("to one structure" in note for note in model.notes)
        for model in (
            extract(spoilt, coherence=None, averages=CLEAN, method=METHOD, bands=[band])
            for band in ((20.0, 250.0), (20.0, 800.0))
        )
    ]
    assert told == [False, True]


def test_the_most_prominent_modes_are_kept_and_the_others_named(plain_beam: Beam, freq: np.ndarray) -> None:
    frf, coherence = noise_of(plain_beam.frf(freq), 3, averages=100)
    model = extract(frf, coherence=coherence, averages=100, method=METHOD, n_modes=3)
    assert len(model.modes) == 3
    assert sum("less prominent" in note for note in model.notes) == 5
    more = extract(frf, coherence=coherence, averages=100, method=METHOD, n_modes=12)
    assert "12 modes requested, 8 found" in more.notes


def test_a_method_that_is_none_is_refused_with_all_that_are(plain_beam: Beam, freq: np.ndarray) -> None:
    with pytest.raises(InvalidInputError, match="no extraction method"):
        extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, method="guess")
