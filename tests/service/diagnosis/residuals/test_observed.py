from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.estimation.windows import WINDOWS
from modallab.rig.measure import Route, measure
from tests.diagnosing import draw_measurement, exact, model, predicting, rig


# 12 tests of 160 lines and 1 to 6 channels: means of 1,900 to 11,500 squares, known to 1 to 3 %; at
# 10 averages the errors are first order only (4 to 11 % off there).
@pytest.mark.parametrize(("averages", "tolerance"), [(10, 0.15), (100, 0.06)])
@pytest.mark.parametrize("roving", [True, False])
def test_residuals_of_the_truth_have_mean_square_one_in_every_part(
    averages: int, tolerance: float, roving: bool
) -> None:
    found: dict[str, list[float]] = {}
    for seed in range(12):
        predictor, observed = predicting(
            draw_measurement(rig(averages=averages, noise=3e-3, roving=roving), seed=seed)
        )
        for part, gap in predictor.residual(()).gaps(observed.usable).items():
            found.setdefault(part, []).append(gap)
    for part, gaps in found.items():
        assert np.mean(gaps) == pytest.approx(1.0, abs=tolerance), part


@pytest.mark.parametrize("estimator", ["h2", "hv"])
def test_every_estimator_gives_the_same_h1(estimator: str) -> None:
    h1 = observe(draw_measurement(rig(noise=1e-2)), (), fraction=0.0)
    other = observe(draw_measurement(rig(noise=1e-2, estimator=estimator)), (), fraction=0.0)
    # The same draw by another estimator: equal to rounding, which low coherence magnifies.
    np.testing.assert_allclose(other.h, h1.h, rtol=1e-9)


def test_few_lines_without_coherence_are_refused_by_name() -> None:
    short = exact(rig()).by_line(lambda array: array[:40])
    with pytest.raises(InvalidInputError) as refused:
        observe(replace(short, coherence=None), (), fraction=0.0)
    assert refused.value.context["field"] == "coherence"


def test_without_coherence_the_scatter_of_lines_tells_the_random_error() -> None:
    noisy = replace(rig(noise=1e-2), analyser=replace(rig().analyser, n_lines=801))
    test = measure(model(), noisy, route=Route.DRAWN, rng=np.random.default_rng(5))
    known = observe(test, (), fraction=0.0)
    unknown = observe(replace(test, coherence=None), (), fraction=0.0)
    ratio = np.median(unknown.error[1:], axis=0) / np.median(known.error[1:], axis=0)
    # errors of one line differ by the coherence there; a floor is at the median line what it is on average
    assert (ratio > 0.5).all()
    assert (ratio < 2.0).all()


def test_two_averages_leave_no_random_error_to_weigh_by() -> None:
    with pytest.raises(InvalidInputError) as refused:
        observe(replace(exact(rig()), averages=2.0), (), fraction=0.0)
    assert refused.value.context["field"] == "averages"


def test_a_measurement_without_a_coherent_line_is_refused_by_name() -> None:
    measurement = exact(rig())
    with pytest.raises(InvalidInputError) as refused:
        observe(replace(measurement, coherence=np.zeros(measurement.frf.values.shape[:2])), (), fraction=0.0)
    assert refused.value.context["field"] == "coherence"


def test_something_must_be_left_to_fit() -> None:
    measurement = exact(rig())
    with pytest.raises(InvalidInputError) as refused:
        observe(measurement, list(map(FrfSelection, measurement.frf.outputs)), fraction=0.25)
    assert refused.value.context["field"] == "hold_out"


def test_what_is_held_out_is_not_fitted() -> None:
    measurement = draw_measurement(rig())
    held = [FrfSelection(dof) for dof in measurement.frf.outputs[2:4]]
    observed = observe(measurement, held, fraction=0.25)
    assert not observed.fitted[:, 2:4].any()
    assert observed.held_out_mask[:, 2:4].any()
    assert not (observed.fitted & observed.held_out_mask).any()
    assert ((observed.fitted | observed.held_out_mask) == observed.usable).all()


def test_lines_are_held_out_where_no_response_is() -> None:
    observed = observe(draw_measurement(rig()), (), fraction=0.25)
    assert 0.2 < observed.held_out_mask.sum() / observed.usable.sum() < 0.3


def test_a_noise_free_measurement_has_a_finite_gap() -> None:
    predictor, observed = predicting(exact(rig(noise=0.0)))
    # The prediction is the measurement; what is left is rounding, far below the numerical floor.
    assert predictor.residual(()).gap(observed.usable) < 1e-3


@pytest.mark.parametrize("kind", [FrfKind.MOBILITY, FrfKind.RECEPTANCE])
def test_a_test_of_another_kind_is_seen_as_the_same_test(kind: FrfKind) -> None:
    inertance = draw_measurement(rig(noise=3e-3))
    predictor, observed = predicting(inertance)
    other = inertance.to(kind)  # without 0 Hz, where it has no value
    check_comparable(model(), other)
    same_predictor, same = predicting(other)
    assert same.freq.tolist() == observed.freq.tolist()
    np.testing.assert_array_equal(same.usable, observed.usable)
    for name in ("h", "incoherent", "force", "error"):
        # factors of omega and back: rounding
        np.testing.assert_allclose(
            getattr(same, name)[1:], getattr(observed, name)[1:], rtol=1e-12, err_msg=name
        )
    gaps = predictor.residual(()).gaps(observed.usable)
    found = same_predictor.residual(()).gaps(same.usable)
    # a residual is a difference of logarithms over its error of 0.1 %: rounding times a thousand
    assert found == pytest.approx(gaps, rel=1e-9)


def test_receptance_with_a_line_at_rest_is_weighed_above_it() -> None:
    receptance = draw_measurement(rig(noise=3e-3)).to(FrfKind.RECEPTANCE)
    # there, receptance of a free body is any number, or none
    still = receptance.by_line(
        lambda array: np.concatenate([array[:1], array]) if array.ndim > 1 else np.r_[0.0, array]
    )
    predictor, observed = predicting(still)
    assert not observed.usable[0].any()
    gaps = predictor.residual(()).gaps(observed.usable)
    without, same = predicting(receptance)
    assert gaps == pytest.approx(without.residual(()).gaps(same.usable), rel=1e-9)  # rounding


@pytest.mark.parametrize("window", ["rectangular", "hann", "flat_top"])
def test_lines_that_lose_power_with_the_mean_of_records_are_not_compared_of_an_uploaded_test(
    window: str,
) -> None:
    test = draw_measurement(rig(kind="random", window=window, noise=1e-8))
    uploaded = observe(replace(test, route=None), (), fraction=0.0).usable[:, 0]
    own = observe(test, (), fraction=0.0).usable[:, 0]
    records = np.random.default_rng(2).standard_normal((4000, 256))
    shape = WINDOWS[window].samples(256)
    with_mean, without = (
        (np.abs(np.fft.rfft(shape * each, axis=1)) ** 2).mean(axis=0)[:12]
        for each in (records, records - records.mean(axis=1, keepdims=True))
    )
    # Lines beyond the window's reach change by rounding alone, those within it by a tenth and more.
    changed = np.abs(without / with_mean - 1) > 1e-6
    np.testing.assert_array_equal(uploaded[:12], own[:12] & ~changed)
    np.testing.assert_array_equal(uploaded[12:], own[12:])
