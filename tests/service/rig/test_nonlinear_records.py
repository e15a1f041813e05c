"""Nonlinear structures: stepped records against straight lines with their residuals' power."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import DivergedError, InvalidInputError
from modallab.core.progress import silent
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.friction import Friction
from modallab.effects.rattle import Rattle
from modallab.estimation.coherence import coherence, coherence_error, frf_error
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Support
from modallab.rig import records
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import Chain, chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter
from modallab.rig.measure import Route, measure
from modallab.rig.record_settings import RECORDS
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup
from tests.rigs import dofs, steel_beam

TIP = Dof(9, "Y")
CANTILEVER = assemble(
    replace(
        steel_beam(StructuralDamping(stiffness_coefficient=0.08), n_elements=8),
        supports=(Support(1, ("Y", "RZ")),),
    )
)
AVERAGES = 200
MILD: list[Effect] = [
    CubicStiffness(TIP, 5e6),
    Friction(TIP, 0.3, 3e-3),
    Rattle(TIP, 300.0, 1.5e-4),
]


def bench(effect: Effect, excitation: str, level: float = 5.0) -> Chain:
    """A cantilever to 200 Hz, modes at 10, 64 and 180 Hz, its shaker with an armature."""
    analyser = Analyser(
        200.0, 101, "hann", averages=AVERAGES, excitation=ExcitationSetting(excitation, level)
    )
    return chain(
        CANTILEVER, RigSetup(dofs(5), dofs(5, 9), Exciter(armature_mass=0.05), analyser=analyser), [effect]
    )


def drawn_and_expected(effect: Effect, excitation: str) -> tuple[CrossSpectra, CrossSpectra]:
    whole = bench(effect, excitation)
    return sampled_spectra(whole, np.random.default_rng(8), silent), expected_spectra(whole)


@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
@pytest.mark.parametrize("effect", MILD, ids=lambda effect: effect.kind)
def test_stepped_records_and_straight_lines_agree_where_the_force_is_mild(
    effect: Effect, excitation: str
) -> None:
    sampled, expected = drawn_and_expected(effect, excitation)
    g2 = coherence(expected)[:, 1:]
    ratio = np.abs(h1(sampled) / h1(expected))[:, 1:, :, 0]
    # of normal errors 99.7 % lie within three; the motion is Gaussian to first order only
    assert (np.abs(ratio - 1) < 3 * frf_error(g2, AVERAGES) + 1e-3).mean() >= 0.99
    within = np.abs(coherence(sampled)[:, 1:] / g2 - 1) < 4 * coherence_error(g2, AVERAGES) + 2e-3
    assert within.mean() >= 0.97
    power = np.abs(sampled.xx / expected.xx - 1)[:, 1:] < 3 / np.sqrt(AVERAGES)
    assert power.mean() >= 0.97


@pytest.mark.parametrize("effect", MILD, ids=lambda effect: effect.kind)
def test_the_force_is_seen_in_frf_and_coherence(effect: Effect) -> None:
    with_it, without = (
        expected_spectra(bench(one, "periodic_random"))
        for one in (effect, effect.with_parameters({next(iter(effect.specs())): 0.0}))
    )
    error = frf_error(coherence(with_it), AVERAGES)[:, 1:]
    assert (np.abs(h1(with_it) / h1(without) - 1)[:, 1:, :, 0] / error).max() > 3
    assert coherence(with_it)[:, 1:].min() < 0.97


def test_a_hardening_spring_raises_the_resonance_with_the_level_and_friction_loses_its_damping() -> None:
    def first(effect: Effect, level: float) -> tuple[float, float]:
        frequencies, widths = bench(effect, "periodic_random", level).poles()
        return float(frequencies[0, 0]), float(widths[0, 0])

    soft, hard = (first(CubicStiffness(TIP, 5e6), level)[0] for level in (1.0, 10.0))
    assert hard > 1.05 * soft
    stuck, loose = (first(Friction(TIP, 0.3, 3e-3), level)[1] for level in (1.0, 10.0))
    assert loose < 0.9 * stuck


def test_the_same_seed_gives_the_same_bytes() -> None:
    one, other = (
        sampled_spectra(bench(MILD[0], "periodic_random"), np.random.default_rng(2), silent) for _ in range(2)
    )
    assert one.fx.tobytes() == other.fx.tobytes()


def test_runs_that_are_stepped_side_by_side_are_as_each_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    analyser = Analyser(200.0, 51, averages=6, excitation=ExcitationSetting("periodic_random", 5.0))
    setup = RigSetup(dofs(5), dofs(5, 7, 9), Exciter(armature_mass=0.05), analyser=analyser)
    # a heavy accelerometer, so that the runs differ in their modes and in the spring they feel
    whole = chain(CANTILEVER, replace(setup, accelerometers=Accelerometers(mass=0.3)), MILD[:2])

    def measured() -> CrossSpectra:
        return sampled_spectra(whole, np.random.default_rng(3), silent)

    together = measured()
    monkeypatch.setattr(records, "RECORDS", replace(RECORDS, parallel_samples=1))
    alone = measured()
    # rounding, which a start from rest does not let grow
    np.testing.assert_allclose(together.fx, alone.fx, rtol=1e-9, atol=1e-9 * np.abs(alone.fx).max())


def test_a_force_too_steep_to_be_stepped_is_refused_by_name() -> None:
    analyser = Analyser(40.0, 401, averages=4, excitation=ExcitationSetting("periodic_random", 100.0))
    long = assemble(STRUCTURES["cantilever"]())
    # steps of 3 ms, and at 100 N a spring that throws the tip back within one of them
    whole = chain(long, RigSetup(dofs(6), dofs(21), analyser=analyser), [CubicStiffness(Dof(21, "Y"), 1e9)])
    with pytest.raises(DivergedError, match="too steep"):
        sampled_spectra(whole, np.random.default_rng(1), silent)


def test_friction_that_holds_modes_too_hard_is_refused_and_not_measured_wrongly() -> None:
    """Records that grow for as long as they last may still be finite at their end."""
    with pytest.raises(DivergedError, match="9:\\+Y holds too hard"):
        sampled_spectra(bench(Friction(TIP, 30.0, 3e-3), "random"), np.random.default_rng(1), silent)


def test_a_force_too_strong_for_straight_lines_is_measured_by_steps_only() -> None:
    def measured(level: float, route: Route) -> FloatArray:
        analyser = Analyser(40.0, 81, averages=10, excitation=ExcitationSetting("periodic_random", level))
        setup = RigSetup(dofs(6), dofs(6, 21), analyser=analyser)
        effects = [CubicStiffness(Dof(21, "Y"), 1e9)]
        rng = np.random.default_rng(1)
        found = measure(STRUCTURES["cantilever"](), setup, effects, route=route, rng=rng)
        assert found.response_spectrum is not None
        return np.asarray(np.sqrt(found.response_spectrum[1:].sum(axis=0)))

    # at 1 N residuals cause 1 % of the mean square of the motion; ten averages scatter by 10 %
    np.testing.assert_allclose(measured(1.0, Route.SAMPLED), measured(1.0, Route.EXPECTED), rtol=0.2)
    assert np.isfinite(measured(10.0, Route.SAMPLED)).all()
    for route in (Route.EXPECTED, Route.DRAWN):
        with pytest.raises(InvalidInputError, match="too strong at this level") as caught:
            measured(10.0, route)
        assert caught.value.context["field"] == "route"
