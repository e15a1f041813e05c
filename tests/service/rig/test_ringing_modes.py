"""What rings on beyond a record: poles and residues of known spectra, and the lines of records."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.local_damping import LocalDamping
from modallab.fe.assembly import assemble
from modallab.fe.damping import Damping, StructuralDamping, ViscousDamping
from modallab.rig.acquisition import sample_rate_of, samples_of
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import Chain, chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.free_decay import blow_lines, impulse_responses_of
from modallab.rig.hardware import Accelerometers, Exciter
from modallab.rig.ringing_modes import Spectra, ringing_modes
from modallab.rig.setup import RigSetup
from tests.rigs import dofs, steel_beam

LIGHT = StructuralDamping(stiffness_coefficient=0.005)
N = 512  # samples of a record


def struck(damping: Damping = LIGHT, n_lines: int = 201, *effects: object, **analyser: object) -> Chain:
    """Return the chain of a free beam that a hammer strikes at two points."""
    settings = Analyser(800.0, n_lines, excitation=ExcitationSetting("impact", pre_trigger=0.25), **analyser)  # type: ignore[arg-type]
    setup = RigSetup(dofs(1, 9), dofs(1, 5), exciter=Exciter("hammer"), analyser=settings)
    return chain(assemble(steel_beam(damping)), setup, effects)  # type: ignore[arg-type]


def decays(poles: ComplexArray, amplitudes: ComplexArray) -> Spectra:
    """Return spectra (n, k) by frequency in lines of decays in samples, as `ringing_modes` asks for them."""

    def spectra(line: FloatArray) -> ComplexArray:
        turn = np.exp(2j * np.pi * (poles - line[:, None] / N))
        mirrored = np.exp(2j * np.pi * (-poles.conj() - line[:, None] / N))
        return np.asarray(1 / (1 - turn) @ amplitudes + 1 / (1 - mirrored) @ amplitudes.conj())

    return spectra


@pytest.mark.parametrize(
    "lines",
    [
        [40.3 + 0.2j],
        [40.3 + 0.2j, 40.6 + 0.1j, 90.0 + 3.0j],  # a pair half a line apart
        [20.0 + 0j, 60.5 + 1e-9j],  # undamped, on a line and between two
        [0.02 + 1e-4j, 30.0 + 0.5j],  # a body on very soft springs
        [8.0 + 1.0j + 1.7 * i for i in range(12)],  # crowded: neighbours overlap
    ],
)
def test_poles_and_amplitudes_of_known_decays_are_found(lines: list[complex]) -> None:
    rng = np.random.default_rng(0)
    poles = np.asarray(np.array(lines) / N, complex)
    amplitudes: ComplexArray = np.asarray(rng.standard_normal((len(lines), 10)).view(complex), complex)
    found = ringing_modes(decays(poles, amplitudes), poles.real * N, poles.imag * N, N)
    after = np.arange(N, 2 * N)[:, None]
    wanted, got = (
        (np.exp(2j * np.pi * p * after) @ a).real
        for p, a in ((poles, amplitudes), (found.poles, found.amplitudes))
    )
    # rounding, times how crowded poles are
    np.testing.assert_allclose(got, wanted, atol=1e-6 * np.abs(wanted).max())


def test_a_motion_that_dies_away_without_oscillation_counts_once() -> None:
    pole, amplitude = np.array([0.3j / N], complex), np.array([[1.0 + 0j]], complex)
    spectra = decays(pole, np.asarray(0.5 * amplitude, complex))
    found = ringing_modes(spectra, np.zeros(0), np.zeros(0), N)
    after = np.arange(N, 2 * N)
    got = 2 * (np.exp(2j * np.pi * found.poles * after[:, None]) @ found.amplitudes).real[:, 0]
    np.testing.assert_allclose(got, np.exp(-2 * np.pi * 0.3 * after / N), rtol=1e-6)  # rounding


def lines_by_time(bench: Chain, run: int) -> ComplexArray:
    """Return the lines (n_lines, n_ch) of a blow's record, cut in time out of one sixteen times as long."""
    analyser = bench.setup.analyser
    n = samples_of(analyser)
    finer = replace(analyser, n_lines=16 * (analyser.n_lines - 1) + 1)
    assert samples_of(finer) == 16 * n  # of lengths without large factors
    long = impulse_responses_of(replace(bench, setup=replace(bench.setup, analyser=finer)), run)
    begin = 16 * n - round(analyser.excitation.pre_trigger * n)
    record = long.samples[0, :, begin : begin + n]
    weights = analyser.line_window.weights(n, 1, len(record) - 1) / np.sqrt(analyser.line_window.power)
    lines = scipy.fft.rfft(record * weights)[:, : analyser.n_lines].T
    return np.asarray(lines * np.sqrt(2 / sample_rate_of(analyser)))


@pytest.mark.parametrize("window", ["rectangular", "hann", "exponential", "force_exponential"])
@pytest.mark.parametrize("damping", [LIGHT, ViscousDamping(1e-6)], ids=["structural", "viscous"])
def test_the_lines_of_a_blow_are_those_of_a_record_cut_out_of_a_long_one(
    window: str, damping: Damping
) -> None:
    bench = struck(
        damping, 201, window=window, force_width=0.5
    )  # modes ring for up to 60 records, and for 2,000
    found = blow_lines(bench)
    assert found is not None
    for run in (0, 1):
        wanted = lines_by_time(bench, run)
        # the filter's ringing before the record: 4e-5 at the last line
        error = np.abs(found[run] - wanted) / np.abs(wanted).max(axis=0)
        assert error.max() < 5e-5


def test_runs_with_resonances_of_their_own_each_get_theirs() -> None:
    bench = struck(LIGHT, 201)
    setup = replace(
        bench.setup, drives=dofs(1), responses=dofs(1, 5, 9), accelerometers=Accelerometers(0.2, roving=True)
    )
    roving = chain(assemble(steel_beam(LIGHT)), setup)
    assert len(roving.runs) == 3
    found = blow_lines(roving)
    assert found is not None
    for run in range(3):
        alone = blow_lines(replace(roving, runs=(roving.runs[run],)))
        assert alone is not None
        np.testing.assert_allclose(found[run], alone[0], rtol=1e-9)  # order of sums


@pytest.mark.parametrize(
    "effect", [GroundSpring(Dof(9, "Y"), stiffness=1e-3), LocalDamping(Dof(9, "Y"), damping=0.02)]
)
def test_a_free_structure_can_be_struck_on_the_softest_of_springs_and_dampers(effect: Effect) -> None:
    """A rigid-body mode of 1e-3 Hz that hardly decays moves no line: the record is that of the free body."""
    free, held = (expected_spectra(struck(LIGHT, 201, *effects)) for effects in ((), (effect,)))
    # a damper of 0.02 N s/m, of 4 times that on the smallest modal mass, 1.5 kg: 0.03 of 0.4 rad/s
    np.testing.assert_allclose(held.fx, free.fx, atol=0.05 * np.abs(free.fx).max())
    assert np.isfinite(held.xx).all()
