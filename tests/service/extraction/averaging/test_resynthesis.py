from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel, Mode
from modallab.estimation.windows import WINDOWS
from modallab.extraction.averaging.resynthesis import resynthesise, with_resynthesis
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping, ExtractionOptions
from modallab.extraction.preprocessing.bands import find_bands, mode_indicator
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.responses import responses_of
from modallab.rig.measure import Route, measure
from tests.rigs import rig, steel_beam
from tests.service.extraction.conftest import DRIVE, RESPONSES, Beam
from tests.service.extraction.test_extract import CLEAN, noise_of


def exact(of: Beam, n_modes: int = 8) -> ModalModel:
    """Return the exact modes of a beam whose FRFs are all of one structure."""
    shapes = of.constants / np.sqrt(of.constants[:, :1])
    modes = tuple(
        Mode(float(f[0]), float(eta[0]), shape)
        for f, eta, shape in zip(of.frequencies, of.loss_factors, shapes, strict=True)
    )
    return ModalModel(modes[:n_modes], RESPONSES)


def misfit(found: FrfSet, of: Beam, freq: FloatArray) -> FloatArray:
    wanted = of.frf(freq).values
    return np.asarray(np.abs(found.values - wanted).max(axis=(0, 2)) / np.abs(wanted).max(axis=(0, 2)))


def with_truncated(of: Beam, freq: FloatArray) -> ModalModel:
    """Return the exact modes, rigid bodies and, as at the middle of the band, higher modes as residuals."""
    constants, eigenvalues = of.all_constants, of.all_eigenvalues
    middle = (2 * np.pi * freq.mean()) ** 2
    above = (constants[10:] / (eigenvalues[10:] - middle)).sum(axis=0)
    residuals = np.stack([constants[:2].sum(axis=0), above])
    return replace(exact(of), references=(DRIVE,), modal_constant=of.constants, residuals=residuals)


def test_exact_modes_with_residuals_are_the_frf_but_for_the_slope_of_higher_modes(
    plain_beam: Beam, freq: FloatArray
) -> None:
    found = resynthesise(with_truncated(plain_beam, freq), freq, FrfKind.INERTANCE)
    assert (found.outputs, found.inputs, found.kind) == (RESPONSES, (DRIVE,), FrfKind.INERTANCE)
    # the ninth mode, 932 Hz, is no constant up to 800 Hz
    assert misfit(found, plain_beam, freq).max() < 0.02


def test_all_modes_resynthesise_to_rounding(plain_beam: Beam, freq: FloatArray) -> None:
    every = plain_beam.all_constants[2:]
    eigenvalues = plain_beam.all_eigenvalues[2:, 0]
    shapes = every / np.sqrt(every[:, :1])
    modes = tuple(
        Mode(float(np.sqrt(one.real) / (2 * np.pi)), float(one.imag / one.real), shape)
        for one, shape in zip(eigenvalues, shapes, strict=True)
    )
    rigid = plain_beam.all_constants[:2].sum(axis=0)
    residuals = np.stack([rigid, np.zeros(11)])
    model = ModalModel(modes, RESPONSES, references=(DRIVE,), modal_constant=every, residuals=residuals)
    found = resynthesise(model, freq[1:]).values[:, :, 0]
    # damping in proportion to mass holds rigid bodies too, which residuals cannot tell
    x = (2 * np.pi * freq[1:, None, None]) ** 2
    held = (plain_beam.all_constants[:2] / (plain_beam.all_eigenvalues[:2] - x)).sum(axis=1)
    wanted = plain_beam.receptance(freq[1:]) - held - rigid / x[:, 0]
    # rounding of 42 modes, and of rigid bodies that are a hundred times as large at 2 Hz
    np.testing.assert_allclose(found, wanted, atol=1e-10 * np.abs(wanted).max(axis=0).min())


def test_every_kind_is_the_derivative_of_the_one_before(plain_beam: Beam) -> None:
    model, freq = with_truncated(plain_beam, np.linspace(0, 800, 401)), np.linspace(5.0, 700.0, 300)
    receptance = resynthesise(model, freq)
    for kind in FrfKind:
        found = resynthesise(model, freq, kind)
        np.testing.assert_allclose(found.values, receptance.to(kind).values, rtol=1e-10)  # rounding


def test_another_drive_point_has_the_frfs_of_reciprocity(plain_beam: Beam, freq: FloatArray) -> None:
    model = exact(plain_beam)
    first = resynthesise(model, freq[1:], drive=DRIVE)
    for column, dof in enumerate(RESPONSES):
        found = resynthesise(model, freq[1:], drive=dof)
        np.testing.assert_allclose(found.values[:, 0, 0], first.values[:, column, 0], rtol=1e-10)  # rounding
    turned = resynthesise(model, freq[1:], drive=Dof(1, "Y", -1))
    np.testing.assert_array_equal(turned.values, -first.values)


def test_extraction_says_what_its_modes_leave_of_each_frf(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    model = extract(frf, coherence=None, averages=CLEAN)
    assert model.resynthesis_error is not None
    # the ninth mode as a constant, and the damping of a first mode 0.1 line wide
    assert model.resynthesis_error.max() < 0.02
    responses = responses_of(frf, None, CLEAN)
    first = find_bands(mode_indicator(responses.mobility, responses.coherent))[0].first
    inside = responses.freq[first:]
    found = resynthesise(model, inside, FrfKind.MOBILITY).values[:, :, 0]
    measured = responses.mobility[first:]
    rms = np.sqrt((np.abs(found - measured) ** 2).mean(axis=0) / (np.abs(measured) ** 2).mean(axis=0))
    np.testing.assert_allclose(rms, model.resynthesis_error, rtol=1e-6)  # rounding
    assert model.residuals is not None
    rigid = plain_beam.all_constants[:2].sum(axis=0).real
    # what lies below is rigid bodies; their damping, and the slope of the ninth mode, tilt a few per cent
    np.testing.assert_allclose(model.residuals[0].real, rigid, atol=0.1 * np.abs(rigid).max())


def test_random_error_is_what_stays_of_a_noisy_test(plain_beam: Beam, freq: FloatArray) -> None:
    frf, coherence = noise_of(plain_beam.frf(freq), 2, averages=100)
    model = extract(frf, coherence=coherence, averages=100)
    assert model.resynthesis_error is not None
    noise = np.sqrt(0.01 / 1.01 / 100)  # of every line: coherence 1/1.01, 100 averages, near the resonances
    assert (model.resynthesis_error > 0.3 * noise).all()
    assert (model.resynthesis_error < 3 * noise).all()
    assert not any(note.startswith("modes and residuals") for note in model.notes)


def test_each_frf_of_a_roving_test_is_of_its_own_structure(roving_beam: Beam, freq: FloatArray) -> None:
    model = extract(roving_beam.frf(freq), coherence=None, averages=CLEAN)
    assert model.frequency_inconsistency is not None
    assert model.resynthesis_error is not None
    assert model.resynthesis_error.max() < 0.02
    one_structure = resynthesise(replace(model, frequency_inconsistency=None), freq, FrfKind.INERTANCE)
    # one common pole misses resonances by up to a bandwidth
    assert misfit(one_structure, roving_beam, freq).max() > 0.2


def test_a_mode_left_out_is_missed_and_said(plain_beam: Beam, freq: FloatArray) -> None:
    model = extract(plain_beam.frf(freq), coherence=None, averages=CLEAN, n_modes=3)
    assert model.resynthesis_error is not None
    assert model.resynthesis_error.max() > 0.1
    assert any(note.startswith("modes and residuals leave more than 10 %") for note in model.notes)


def test_noise_without_coherence_is_told_from_what_modes_leave(plain_beam: Beam, freq: FloatArray) -> None:
    frf = plain_beam.frf(freq)
    parts = np.random.default_rng(0).standard_normal((2, *frf.values.shape))
    level = 0.05 * np.abs(frf.values).std()  # of inertance: much where an FRF is small
    noisy = replace(frf, values=frf.values + level * (parts[0] + 1j * parts[1]))
    for n_modes, said in ((None, False), (3, True)):
        model = extract(noisy, coherence=None, averages=CLEAN, n_modes=n_modes)
        assert model.resynthesis_error is not None
        assert model.resynthesis_error.max() > 0.1
        notes = [note for note in model.notes if note.startswith("modes and residuals leave more than 10 %")]
        assert bool(notes) is said


def test_viscous_modes_resynthesise_as_viscous_ones() -> None:
    freq = np.linspace(1.0, 100.0, 991)
    omega, pole, ratio = 2 * np.pi * freq, 2 * np.pi * 40.0, 0.03
    values = -(omega**2) * (2.0 / (pole**2 - omega**2 + 2j * ratio * pole * omega) + 3e-6)
    frf = FrfSet(freq, values.astype(complex)[:, None, None], (DRIVE,), (DRIVE,), FrfKind.INERTANCE)
    errors = {}
    for law in Damping:
        model = extract(frf, coherence=None, averages=CLEAN, options=ExtractionOptions(damping=law))
        assert model.resynthesis_error is not None
        errors[law] = float(model.resynthesis_error[0])
    assert errors[Damping.VISCOUS] < 1e-6  # the mirror pole is taken off step by step
    assert errors[Damping.STRUCTURAL] > 1e-4  # the wrong law, of a loss factor of 6 %


def test_frfs_that_cannot_be_are_refused(plain_beam: Beam, freq: FloatArray) -> None:
    model = exact(plain_beam)
    with pytest.raises(InvalidInputError, match="at the drive point"):
        resynthesise(model, freq)
    with pytest.raises(InvalidInputError, match="at the drive point"):
        resynthesise(model, freq, drive=Dof(2, "Y"))
    with pytest.raises(InvalidInputError, match="mass-normalised"):
        resynthesise(replace(model, normalisation="none"), freq, drive=DRIVE)
    with pytest.raises(InvalidInputError, match="0 Hz"):
        resynthesise(with_truncated(plain_beam, freq), freq, FrfKind.MOBILITY)


def test_lines_that_a_window_holds_down_are_not_asked_of_the_modes() -> None:
    setup = rig(*range(1, 22, 4), excitation="random", analyser={"window": "hann", "estimator": "h1"})
    leaked = measure(steel_beam(), setup, (), route=Route.EXPECTED, rng=np.random.default_rng(0))
    window = WINDOWS["hann"].samples(1024)
    model = extract(
        leaked.frf, coherence=None, averages=CLEAN, leakage=WindowLeakage.from_window(window, "h1")
    )
    responses = responses_of(leaked.frf, None, CLEAN)
    bands = find_bands(mode_indicator(responses.mobility, responses.coherent))
    all_lines = with_resynthesis(model, responses, bands)
    assert model.resynthesis_error is not None
    assert all_lines.resynthesis_error is not None
    # beside the resonances H1 of leaked data follows the modes to a tenth or so, antiresonances included
    assert model.resynthesis_error.max() < 0.2
    assert all_lines.resynthesis_error.max() > 0.3
