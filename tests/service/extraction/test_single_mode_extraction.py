import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping, DistantLinesOptions, ExtractionOptions, SingleModeOptions
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from tests.service.extraction.conftest import Beam
from tests.synthetic import HAMMERED, HAMMERED_LOSS, hammered

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if EXTRACTION_METHODS[kind].exact]
FREQ: FloatArray = np.arange(20.0, 400.0, 0.5)
DOFS = (Dof(1, "Y"), Dof(2, "Y"))
FREQUENCIES = np.array([60.3, 140.7, 290.2])
RATIOS = np.array([0.05, 0.03, 0.04])
SHAPES = np.array([[1.0, 0.8], [0.9, -0.7], [0.7, 0.6]])


def viscous_set() -> FrfSet:
    """Two FRFs of three real modes with viscous damping of 3 to 5 %, well apart."""
    omega, omega_r = 2 * np.pi * FREQ[:, None], 2 * np.pi * FREQUENCIES
    each = 1 / (omega_r**2 - omega**2 + 2j * RATIOS * omega_r * omega)
    values = np.asarray(-(omega[:, :, None] ** 2) * (each @ (SHAPES * SHAPES[:, :1]))[:, :, None])
    return FrfSet(FREQ, values, DOFS, DOFS[:1], FrfKind.INERTANCE)


def modes_of(options: ExtractionOptions, method: str = "dobson") -> ModalModel:
    return extract(viscous_set(), coherence=None, averages=1e6, method=method, options=options)


@pytest.mark.parametrize("method", EXACT)
def test_viscous_modes_of_five_per_cent_come_back_where_the_other_law_errs(method: str) -> None:
    model = modes_of(ExtractionOptions(damping=Damping.VISCOUS), method)
    other = modes_of(ExtractionOptions(damping=Damping.STRUCTURAL), method)
    assert model.choices["damping"].startswith("viscous")
    assert model.modal_constant is not None
    off = np.abs(model.loss_factors / (2 * RATIOS) - 1)
    phase = np.angle(model.modal_constant[:, 0])
    # left over: what three rounds of taking neighbours off leave of modes ten bandwidths apart
    np.testing.assert_allclose(model.frequencies, FREQUENCIES, rtol=1e-4)
    assert off.max() < 2e-3
    assert np.abs(phase).max() < 2e-3
    assert other.modal_constant is not None
    # constant damping, where it rises with frequency, is a twist of the response about resonance
    assert np.abs(np.angle(other.modal_constant[:, 0])).max() > 10 * np.abs(phase).max()


def test_of_a_hammer_modes_are_read_where_it_excites_and_noise_above_is_named() -> None:
    frf = hammered(3, 3)
    model = extract(frf, coherence=None, averages=100.0)
    # noise is 0.4 of the force at 698.5 Hz, four times as large at 1293 Hz and eleven at 1655 Hz
    np.testing.assert_allclose(model.frequencies, HAMMERED[:7], rtol=5e-5)
    np.testing.assert_allclose(model.loss_factors[:5], HAMMERED_LOSS[:5], rtol=0.01)
    assert any("peaks" in note and "classified as noise" in note for note in model.notes)
    assert any("by the scatter of neighbouring lines" in note for note in model.notes)


@pytest.mark.parametrize("method", [kind for kind in EXACT if EXTRACTION_METHODS[kind].leaves_out])
def test_the_lines_left_out_may_hold_anything(method: str, plain_beam: Beam) -> None:
    freq = np.arange(440.0, 735.0)  # one line a Hz; mode 7 is 2.9 lines wide at 587.5 Hz
    frf = plain_beam.frf(freq)
    values = frf.values.copy()
    values[146:150] *= np.array([1.2, 1.3, 1.4, 1.1])[:, None, None]  # 586 to 589 Hz
    spoilt = FrfSet(freq, values, frf.outputs, frf.inputs, frf.kind)
    bands = [(550.0, 620.0)]
    off = []
    for leave_out in (0, 4):
        options = DistantLinesOptions(lines=20, leave_out=leave_out)
        model = extract(spoilt, coherence=None, averages=1e6, method=method, options=options, bands=bands)
        off.append(abs(model.loss_factors[0] / plain_beam.loss_factors[6, 0] - 1))
    # the beam's other modes, of which one band knows only a constant, bend 20 lines by so much
    assert off[1] < 0.02
    assert off[0] > 3 * off[1]


def test_a_fit_draws_on_as_many_lines_as_asked_and_says_which(plain_beam: Beam, freq: FloatArray) -> None:
    options = SingleModeOptions(lines=10)
    model = extract(plain_beam.frf(freq), coherence=None, averages=1e6, options=options)
    assert model.fitted_lines is not None
    assert model.fitted_lines.shape == (8, 11, 2)
    first, last = model.fitted_lines[:, :, 0], model.fitted_lines[:, :, 1]
    assert (last - first == 9).all()
    above = freq[freq > 0]
    assert (above[first] < model.frequencies[:, None]).all()
    assert (above[last] > model.frequencies[:, None]).all()


def test_bands_too_short_to_leave_lines_out_are_noted(plain_beam: Beam, freq: FloatArray) -> None:
    options = DistantLinesOptions(leave_out=6)
    model = extract(
        plain_beam.frf(freq), coherence=None, averages=1e6, options=options, bands=[(120.0, 136.0)]
    )
    assert any("fewer than 6" in note for note in model.notes)  # nine lines, four of which must stay


def test_a_biased_method_says_so(plain_beam: Beam, freq: FloatArray) -> None:
    model = extract(plain_beam.frf(freq), coherence=None, averages=1e6, method="peak_picking")
    assert any("peak_picking is biased" in note for note in model.notes)
    clean = extract(plain_beam.frf(freq), coherence=None, averages=1e6)
    assert not any("biased" in note for note in clean.notes)


def test_circle_fit_cannot_leave_its_peak_out(plain_beam: Beam, freq: FloatArray) -> None:
    with pytest.raises(InvalidInputError, match="circle_fit needs the lines nearest resonance"):
        extract(
            plain_beam.frf(freq),
            coherence=None,
            averages=1e6,
            method="circle_fit",
            options=DistantLinesOptions(leave_out=2),
        )


def test_peaks_of_noise_are_counted_where_they_are_many() -> None:
    frf = viscous_set()
    rng = np.random.default_rng(5)
    noise = rng.normal(size=(2, *frf.values.shape)) * np.abs(frf.values).max() / 20
    noisy = FrfSet(FREQ, frf.values + noise[0] + 1j * noise[1], DOFS, DOFS[:1], frf.kind)
    model = extract(noisy, coherence=None, averages=100.0)
    (note,) = [note for note in model.notes if "no mode" in note]
    assert "peaks from" in note


def test_where_all_peaks_are_noise_their_number_is_told_and_no_band_that_nobody_gave() -> None:
    rng = np.random.default_rng(11)
    noise = rng.normal(size=(2, len(FREQ), 2, 1))
    frf = FrfSet(FREQ, noise[0] + 1j * noise[1], DOFS, DOFS[:1], FrfKind.INERTANCE)
    with pytest.raises(NoModeInBandError, match=r"at any of \d+ peaks"):
        extract(frf, coherence=np.full((len(FREQ), 2), 0.5), averages=10.0)
