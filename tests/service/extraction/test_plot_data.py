from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract, responses_read
from modallab.extraction.options import Damping, DistantLinesOptions, ExtractionOptions
from modallab.extraction.plot_data import fit_plot_data
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.responses import Responses, responses_of
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit
from tests.service.extraction.conftest import Beam
from tests.service.extraction.leaked_beam import read as read_leaked
from tests.service.extraction.leaked_beam import taken

KINDS = sorted(EXTRACTION_METHODS)
EXACT = [kind for kind in KINDS if EXTRACTION_METHODS[kind].exact]
MODE, ROW = 2, 4  # 128 Hz, at node 9


def read(
    beam: Beam, freq: FloatArray, method: str, options: ExtractionOptions | None = None
) -> tuple[Responses, ModalModel]:
    frf = beam.frf(freq)
    model = extract(frf, coherence=None, averages=1e6, method=method, options=options)
    return responses_of(frf, None, 1e6), model


@pytest.mark.parametrize("kind", EXACT)
def test_the_picture_is_of_the_fit_that_the_model_holds(
    kind: str, plain_beam: Beam, freq: FloatArray
) -> None:
    responses, model = read(plain_beam, freq, kind)
    picture = fit_plot_data(responses, model, MODE, ROW)
    assert model.fitted_frequency is not None
    assert model.modal_constant is not None
    assert model.fitted_lines is not None
    # the neighbours were still moving in the last round of the model: second order of the first guess
    assert picture.frequency == pytest.approx(model.fitted_frequency[MODE, ROW], rel=1e-8)
    assert picture.modal_constant == pytest.approx(complex(model.modal_constant[MODE, ROW]), rel=1e-5)
    first, last = model.fitted_lines[MODE, ROW]
    np.testing.assert_array_equal(picture.freq, responses.freq[first : last + 1])
    assert picture.used.all()


@pytest.mark.parametrize("kind", EXACT)
def test_modes_of_hundreds_of_lines_are_extracted_and_plotted(kind: str, plain_beam: Beam) -> None:
    # 0.004 Hz: the half-power bandwidth of 1.3 Hz has more lines than a fit draws on
    responses, model = read(plain_beam, np.arange(120.0, 136.0, 0.004), kind)
    (mode,) = model.modes
    expected = plain_beam.eigenvalues[MODE, 0].real ** 0.5 / (2 * np.pi)
    # further modes bend the residual by 1e-4 of the peak over the window, as with coarser lines
    assert mode.frequency == pytest.approx(expected, rel=1e-5)
    plot = fit_plot_data(responses, model, 0, ROW)
    assert model.fitted_frequency is not None
    assert plot.frequency == pytest.approx(model.fitted_frequency[0, ROW], rel=1e-8)
    assert 48 < len(plot.freq) <= 96
    assert np.ptp(plot.freq) > 2 * mode.loss_factor * mode.frequency


@pytest.mark.parametrize("kind", EXACT)
def test_cleaned_lines_are_one_mode_and_a_constant(kind: str, plain_beam: Beam, freq: FloatArray) -> None:
    picture = fit_plot_data(*read(plain_beam, freq, kind), MODE, ROW)
    factor = (2j * np.pi * picture.freq) ** (2 if picture.kind is FrfKind.INERTANCE else 0)
    alone = plain_beam.constants[MODE, ROW] / (
        plain_beam.eigenvalues[MODE, ROW] - (2 * np.pi * picture.freq) ** 2
    )
    left = picture.cleaned - factor * alone
    # modes above 800 Hz and rigid bodies bend the constant by 1e-4 of the peak over the window
    assert np.ptp(np.abs(left)) < 1e-3 * np.abs(picture.cleaned).max()
    through = np.interp(picture.curve_freq, picture.freq, np.abs(picture.cleaned))
    assert np.abs(picture.curve).max() >= 0.999 * through.max()
    at_lines = np.interp(picture.freq, picture.curve_freq, picture.curve.real) + 1j * np.interp(
        picture.freq, picture.curve_freq, picture.curve.imag
    )
    # 201 points and straight lines between them, over a peak of 15 points' width
    np.testing.assert_allclose(at_lines, picture.cleaned, atol=0.01 * np.abs(picture.cleaned).max())


def test_the_points_of_a_circle_fit_lie_on_its_circle_and_its_carpet_is_flat(
    plain_beam: Beam, freq: FloatArray
) -> None:
    picture = fit_plot_data(*read(plain_beam, freq, "circle_fit"), MODE, ROW)
    drawn = picture.details
    radius = np.abs(drawn["points"] - drawn["centre"])
    np.testing.assert_allclose(radius, drawn["radius"][0].real, rtol=1e-3)
    np.testing.assert_allclose(np.abs(drawn["circle"] - drawn["centre"]), drawn["radius"][0].real, rtol=1e-12)
    surface = drawn["damping_surface"].real
    assert set(picture.quality) == {"radius_variation", "damping_variation"}
    assert max(picture.quality.values()) < 1.0  # %, of clean lines
    assert surface.shape == (len(drawn["x_above"]), len(drawn["x_below"]))
    np.testing.assert_allclose(surface, picture.loss_factor, rtol=0.01)  # far pairs lean on what is bent
    resonance = np.sqrt(drawn["x_resonance"][0].real) / (2 * np.pi)
    assert resonance == pytest.approx(picture.frequency, rel=1e-12)
    fastest = np.argmax(np.abs(drawn["sweep_rate"]))
    assert abs(np.sqrt(drawn["x_sweep"][fastest].real) / (2 * np.pi) - picture.frequency) < 2.0  # one line


def test_the_lines_of_line_fit_dobson_and_linear_fit_go_through_their_points(
    plain_beam: Beam, freq: FloatArray
) -> None:
    for kind, points, line in (
        ("line_fit", "inverse", "line"),
        ("dobson", "delta", "delta_lines"),
        ("dobson", "slopes", "slope_line"),
        ("linear_fit", "left", "right"),
    ):
        drawn = fit_plot_data(*read(plain_beam, freq, kind), MODE, ROW).details
        largest = np.abs(drawn[points]).max()
        np.testing.assert_allclose(drawn[line], drawn[points], atol=2e-3 * largest, err_msg=kind)


def test_both_stages_of_dobson_give_the_mode_by_their_slopes(plain_beam: Beam, freq: FloatArray) -> None:
    picture = fit_plot_data(*read(plain_beam, freq, "dobson"), MODE, ROW)
    drawn = picture.details
    n = len(picture.freq)
    assert drawn["delta"].shape == drawn["x_delta"].shape == (n, n - 1)
    u, v = np.polyfit(drawn["x"].real, drawn["slope_line"], 1)
    eigenvalue = -v / u
    assert np.sqrt(eigenvalue.real) / (2 * np.pi) == pytest.approx(picture.frequency, rel=1e-9)
    assert eigenvalue.imag / eigenvalue.real == pytest.approx(picture.loss_factor, rel=1e-6)


def test_a_picked_peak_shows_its_half_power_points(plain_beam: Beam, freq: FloatArray) -> None:
    picture = fit_plot_data(*read(plain_beam, freq, "peak_picking"), 7, 0)
    drawn = picture.details
    width = np.diff(drawn["x_half"].real)[0] / drawn["x_peak"].real[0] / 2
    assert width == pytest.approx(picture.loss_factor, rel=1e-9)
    np.testing.assert_allclose(drawn["half"], drawn["peak"][0] / np.sqrt(2))


@pytest.mark.parametrize("kind", KINDS)
def test_every_picture_is_of_numbers(kind: str, plain_beam: Beam, freq: FloatArray) -> None:
    responses, model = read(plain_beam, freq, kind)
    for mode in (0, 1):  # 0.1 lines wide, and still at node 11
        for row in (0, 5):
            picture = fit_plot_data(responses, model, mode, row)
            for name, values in picture.details.items():
                assert np.isfinite(values).all(), name
            assert np.isfinite(picture.curve).all()


@pytest.mark.parametrize("kind", EXACT)
def test_a_fit_of_one_frf_alone_is_the_one_among_all(kind: str, plain_beam: Beam, freq: FloatArray) -> None:
    responses, model = read(plain_beam, freq, kind)
    assert model.fitted_frequency is not None
    assert model.fitted_loss_factor is not None
    assert model.modal_constant is not None
    for mode, row in ((0, 3), (MODE, ROW), (7, 10)):
        picture = fit_plot_data(responses, model, mode, row)
        # its neighbours are taken off as they ended, and no more in turn
        assert picture.frequency == pytest.approx(model.fitted_frequency[mode, row], rel=1e-6)
        assert picture.loss_factor == pytest.approx(model.fitted_loss_factor[mode, row], rel=1e-3)
        assert picture.modal_constant == pytest.approx(model.modal_constant[mode, row], rel=1e-3)


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_a_leaked_fit_of_one_frf_is_the_one_among_all(estimator: str) -> None:
    measurement = taken(estimator)[0]
    leakage = WindowLeakage.from_window(WINDOWS["hann"].samples(1024), estimator)
    model = read_leaked(measurement, estimator, "dobson")
    responses, _ = responses_read(
        measurement.frf,
        measurement.coherence,
        measurement.averages,
        leakage=leakage,
        estimator=estimator,
    )
    assert model.fitted_frequency is not None
    assert model.fitted_loss_factor is not None
    for row in (0, 4, 10):
        picture = fit_plot_data(responses, model, 5, row, leakage=leakage)
        assert picture.frequency == pytest.approx(model.fitted_frequency[5, row], rel=1e-5)
        assert picture.loss_factor == pytest.approx(model.fitted_loss_factor[5, row], rel=1e-2)


def test_lines_left_out_are_shown_but_not_used(plain_beam: Beam, freq: FloatArray) -> None:
    responses, model = read(plain_beam, freq, "line_fit", DistantLinesOptions(lines=12, leave_out=4))
    picture = fit_plot_data(responses, model, MODE, ROW)
    assert len(picture.freq) == 12
    assert picture.used.sum() == len(picture.details["x"]) == 8
    assert np.abs(picture.freq[~picture.used] - picture.frequency).max() < 6.0  # Hz: the nearest, 2 Hz apart


def test_leakage_is_undone_in_the_cleaned_lines_only() -> None:
    mode = ModeFit(100.3, 0.02, 1 + 0.1j, 3e-7)
    freq = np.arange(85.0, 117.0)
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(1024) / 1024)
    leakage = WindowLeakage.from_window(hann, "h2")
    x = (np.arange(-40 * 200, 40 * 200) + 0.5) / 200
    share = 2 / 3 * (np.sinc(x) / (1 - x**2)) ** 2 / 200
    fine = freq[:, None] + x
    inertance = -((2 * np.pi * fine) ** 2) * mode.response(fine)
    h2 = np.abs(inertance) ** 2 @ share / (inertance @ share).conj()
    dof = Dof(1, "Y")
    frf = FrfSet(freq, h2[:, None, None], (dof,), (dof,), FrfKind.INERTANCE)
    model = extract(frf, coherence=None, averages=100, leakage=leakage, bands=[(85.0, 116.0)])
    picture = fit_plot_data(responses_of(frf, None, 100), model, 0, 0, leakage=leakage)
    order = 2 if picture.kind is FrfKind.INERTANCE else 0
    exact = (2j * np.pi * picture.freq) ** order * mode.response(picture.freq)
    # the closed form is of one pole: its mirror image, 200 lines away, bends by 1e-4
    np.testing.assert_allclose(picture.cleaned, exact, rtol=2e-3)
    assert np.abs(picture.measured / exact - 1).max() > 0.05


@pytest.mark.parametrize("kind", EXACT)
def test_a_viscous_fit_is_drawn_in_omega(kind: str) -> None:
    freq = np.arange(60.0, 140.0)
    omega, omega_r = 2 * np.pi * freq, 2 * np.pi * 100.3
    values = np.asarray(1 / (omega_r**2 - omega**2 + 0.1j * omega_r * omega), complex)
    dof = Dof(1, "Y")
    frf = FrfSet(freq, values[:, None, None], (dof,), (dof,), FrfKind.RECEPTANCE)
    options = ExtractionOptions(damping=Damping.VISCOUS)
    model = extract(frf, coherence=None, averages=1e6, method=kind, options=options, bands=[(60.0, 139.0)])
    picture = fit_plot_data(responses_of(frf, None, 1e6), model, 0, 0)
    assert picture.damping is Damping.VISCOUS
    assert picture.loss_factor == pytest.approx(0.1, rel=1e-4)
    if kind == "circle_fit":
        np.testing.assert_allclose(picture.details["damping_surface"].real, 0.1, rtol=2e-3)
        assert picture.details["x_resonance"][0].real == pytest.approx(omega_r, rel=2e-3)  # its damped one
    if kind == "line_fit":
        line = picture.details
        np.testing.assert_allclose(line["line"], line["inverse"], rtol=1e-4)


def test_what_is_no_fit_of_this_model_is_refused(plain_beam: Beam, freq: FloatArray) -> None:
    responses, model = read(plain_beam, freq, "dobson")
    with pytest.raises(InvalidInputError, match="no such mode"):
        fit_plot_data(responses, model, 8, 0)
    with pytest.raises(InvalidInputError, match="no such row"):
        fit_plot_data(responses, model, 0, 11)
    for other in (replace(model, method="plscf"), replace(model, fitted_lines=None)):
        with pytest.raises(InvalidInputError, match="not from fits of single modes"):
            fit_plot_data(responses, other, 0, 0)
    with pytest.raises(InvalidInputError, match="not those that the modes were identified from"):
        fit_plot_data(responses, replace(model, dofs=model.dofs[::-1]), 0, 0)
