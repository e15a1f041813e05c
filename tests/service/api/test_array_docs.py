"""Arrays of replies are described by the dataclasses that hold them."""

from dataclasses import dataclass

from modallab.api.array_docs import arrays_of
from modallab.api.arrays import ArraySpec
from modallab.core.arrays import BoolArray, ComplexArray
from modallab.core.dof import Dof


@dataclass(frozen=True, eq=False)
class Curves:
    """Measured curves."""

    values: ComplexArray
    """m/N, (n_freq, n_out) receptance."""
    level: float
    """N, rms of the force."""
    outputs: tuple[Dof, ...]
    """Response DoFs."""
    held_out: BoolArray | None = None
    """(n_out,), (n_out, n_in) with a roving hammer; None: no curve."""


def test_type_shape_and_meaning_are_those_of_the_field() -> None:
    assert arrays_of(Curves, "values", "level", "outputs", unused="held_out") == {
        "values": ArraySpec("m/N, (n_freq, n_out) receptance.", "n_freq, n_out", "complex"),
        "level": ArraySpec("N, rms of the force.", "", "real"),
        "outputs": ArraySpec("Response DoFs.", "n_outputs", "text"),
        "unused": ArraySpec(
            "(n_out,), (n_out, n_in) with a roving hammer; null: no curve.",
            "n_out | n_out, n_in",
            "flag",
            optional=True,
        ),
    }


def test_the_shape_is_told_once() -> None:
    specs = arrays_of(Curves, "values", "outputs")
    assert specs["values"].schema()["description"] == "m/N, (n_freq, n_out) receptance."
    assert specs["outputs"].schema()["description"] == "(n_outputs) Response DoFs."
