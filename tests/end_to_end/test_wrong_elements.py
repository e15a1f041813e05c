"""The beam of the 1992 thesis, chapter 5: its four wrong elements, found by a diagnosis over HTTP."""

import pytest

from modallab_client import ModalLab
from modallab_client.demo.chapter_5 import RIG, TRUTH
from modallab_client.methods.diagnoses import place

# What moves resonances, or is at the end that is driven: the other kinds would only take time.
SUSPECTS = [
    "stiffness_error",
    "density_error",
    "extra_mass",
    "accelerometer_mass",
    "force_transducer_mass",
    "gain_error",
]
KINDS = {"density": "density_error", "modulus": "stiffness_error"}


def test_the_wrong_elements_of_the_thesis_and_nothing_else_are_named() -> None:
    with ModalLab.embedded() as lab:
        model = lab.structures.catalogue("chapter-5-beam")
        truth = lab.structures.change(model.id, TRUTH)
        test = lab.measurements.start(truth.id, lab.rigs.create(**RIG).id, seed=1).result()
        found = lab.diagnoses.start(model.id, test.id, suspects=SUSPECTS).result()
    assert found.verdict == "explained"
    hidden = {(KINDS[one["property"]], place({"members": one["members"]})): one["factor"] for one in TRUTH}
    named = {(step.effect.kind, place(step.effect.at or "")): step for step in found.steps}
    assert set(named) == set(hidden)
    for name, step in named.items():
        factor = step.effect.parameters["factor"]
        # Random error leaves them known to a part in ten thousand: far within the 2 % that are asked for.
        assert factor.value == pytest.approx(hidden[name], rel=0.02)
        assert factor.standard_error
        assert abs(factor.value - hidden[name]) < 4 * factor.standard_error
        assert (step.probability or 0) > 0.99
        assert step.rivals_alike == ()
    assert (found.steps[0].gap_before or 0) > 1000
    assert abs((found.remaining_gap or 0) - 1) < 4 * (found.remaining_scatter or 0)
