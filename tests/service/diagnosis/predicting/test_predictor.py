from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.core.place import Members
from modallab.diagnosis.predicting.comparability import check_comparable
from modallab.diagnosis.predicting.unmeasured import unmeasured_inertance
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.beam import beam
from modallab.fe.structure import Material, Section
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Exciter
from tests.diagnosing import exact, model, predicting, rig

STIFFER = StiffnessError(at=Members((3,)), factor=1.05)


def test_a_first_look_at_periodic_data_is_exact_at_its_lines() -> None:
    predictor, _ = predicting(exact(rig()))
    look, whole = predictor.coarse_prediction(()).predict([STIFFER]), predictor.predict([STIFFER])
    np.testing.assert_allclose(look.h, whole.h[:: predictor.step], rtol=1e-9)  # the same sums, rounding


def test_a_first_look_at_leaking_data_is_right_to_some_per_cent() -> None:
    predictor, _ = predicting(exact(rig(kind="random", window="hann")))
    look, whole = predictor.coarse_prediction(()).predict([STIFFER]), predictor.predict([STIFFER])
    apart = np.abs(look.h / whole.h[:: predictor.step] - 1)
    # Six points a line against resonances of 0.5 lines: the typical line is right to a per cent.
    assert np.median(apart) < 0.01


def test_differences_on_one_thin_grid_are_those_of_exact_predictions() -> None:
    predictor, observed = predicting(exact(rig(kind="random", window="hann")))
    near, step = predictor.linearisation_at([STIFFER]), 1e-4
    stiffer = STIFFER.with_parameters({"factor": STIFFER.factor + step})
    thin = np.log(near([stiffer]).h / near([STIFFER]).h) / step
    whole = np.log(predictor.predict([stiffer]).h / predictor.predict([STIFFER]).h) / step
    lines = observed.usable
    # Five points of a panel: 1e-3 of a spectrum at the worst line, and of its slope.
    assert np.linalg.norm((thin - whole)[lines]) < 2e-3 * np.linalg.norm(whole[lines])


@pytest.mark.parametrize("end", [1e-3, 0.01])
def test_differences_of_windowed_blows_leave_out_what_rings_on(end: float) -> None:
    struck = replace(
        rig(),
        exciter=Exciter("hammer"),
        analyser=Analyser(
            frequency_max=400.0,
            n_lines=161,
            window="exponential",
            window_end=end,
            excitation=ExcitationSetting("impact"),
        ),
    )
    predictor, observed = predicting(exact(struck))
    near, step = predictor.linearisation_at([STIFFER]), 1e-4
    stiffer = STIFFER.with_parameters({"factor": STIFFER.factor + step})
    decayed = np.log(near([stiffer]).h / near([STIFFER]).h) / step
    whole = np.log(predictor.predict([stiffer]).h / predictor.predict([STIFFER]).h) / step
    lines = observed.usable
    np.testing.assert_allclose(near([STIFFER]).h, predictor.predict([STIFFER]).h, rtol=1e-12)  # one division
    # what rings on is the window's height at the end, most of it at antiresonances, where FRFs are small
    assert np.linalg.norm((decayed - whole)[lines]) < 20 * end * np.linalg.norm(whole[lines])


def test_nearby_models_have_nearly_the_same_distortion() -> None:
    measured = exact(rig(kind="random", window="hann"))
    predictor, observed = predicting(measured)
    hardening, step = CubicStiffness(at=Dof(4, "Y"), stiffness=1e11), 1e-4
    stiffer = StiffnessError(at=None, factor=1 + step)

    def slope(*, same: bool) -> ComplexArray:
        near = predictor.linearisation_at([hardening], same_distortion=same)
        return np.asarray(np.log(near([stiffer, hardening]).h / near([hardening]).h) / step)

    kept, renewed, lines = slope(same=True), slope(same=False), observed.usable
    distorted = predictor.linearisation_at([hardening])([hardening]).h / predictor.predict(()).h
    assert np.abs(np.log(distorted[lines])).max() > 1  # the force changes FRFs by a factor and more
    # What a modulus changes is ten and more times what it changes by way of the motion at the force.
    assert np.linalg.norm((kept - renewed)[lines]) < 0.1 * np.linalg.norm(renewed[lines])


def test_an_unmeasured_response_is_what_the_roving_accelerometer_would_have_seen() -> None:
    from dataclasses import replace

    predictor, observed = predicting(exact(rig(noise=0.0)))
    there = Dof.parse("6:+Y")
    seen = exact(replace(rig(noise=0.0), responses=(there,))).frf.values
    predicted = unmeasured_inertance(predictor, (), (there,))
    lines = observed.freq > 0
    np.testing.assert_allclose(predicted[lines], seen[lines], rtol=1e-9)  # the same sums, rounding


def test_an_axis_that_the_log_book_does_not_declare_is_refused() -> None:
    from dataclasses import replace

    measurement = exact(rig())
    other = replace(measurement.setup, analyser=Analyser(frequency_max=410.0, n_lines=161))
    with pytest.raises(InvalidInputError) as refused:
        check_comparable(model(), replace(measurement, setup=other))
    assert refused.value.context["field"] == "freq"


def test_a_measured_dof_that_the_model_lacks_is_named() -> None:
    short = beam(length=1.0, n_elements=4, section=Section(5e-4, 4e-9), material=Material(2e11, 7800.0))
    with pytest.raises(UnknownDofError) as refused:
        check_comparable(short, exact(rig()))
    assert refused.value.context["value"] == "7:+Y"
