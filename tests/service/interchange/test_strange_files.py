"""Files as other programs write them: what is read, what is assumed, what is refused by name."""

import io

import numpy as np
import pytest

from benchmarks.strange_cases import (
    Case,
    curves,
    damaged_cases,
    flipped_cases,
    matlab,
    npz,
    strange_cases,
    table,
)
from benchmarks.strange_files import error_of, read_case, report_damaged
from modallab.core.errors import InvalidInputError
from modallab.interchange.declared import DeclaredTest
from modallab.interchange.file_content import Piece, fields_from
from modallab.interchange.format import read_pieces
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.reading import read_measurement
from modallab.interchange.reading_options import ReadingOptions
from modallab.rig.measurement import Measurement

CASES = {case.name: case for case in strange_cases()}
DAMAGED = {case.name: case for case in damaged_cases(list(CASES.values()))[::5]}
FLIPPED = {case.name: case for case in flipped_cases(list(CASES.values()))[::40]}


def read_case_here(case: Case) -> Measurement:
    """Return the measurement of a case, read in this process."""
    pieces = [Piece(name, content, k) for k, (name, content) in enumerate(case.files, 1)]
    content = read_pieces(pieces, ReadingOptions(**case.options), largest=200_000_000)
    return MeasuredFile(**fields_from(content.as_json(), content.as_arrays())).without_log_book()


@pytest.mark.parametrize("name", CASES)
def test_a_file_is_read_as_it_was_made(name: str) -> None:
    assert error_of(CASES[name], read_case_here(CASES[name])) <= 1e-6  # nine digits of text


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_file_is_a_named_problem(name: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        read_case_here(DAMAGED[name])
    assert caught.value.context["field"]


@pytest.mark.parametrize("name", FLIPPED)
def test_flipped_bits_are_a_named_problem_or_leave_finite_numbers(name: str) -> None:
    found = report_damaged([FLIPPED[name]], readable=True)
    assert (found.named, found.read, found.unnamed) in ((1, 0, 0), (0, 1, 0))


@pytest.mark.parametrize("name", ["mat 7.3, stated", "the same in a zip"])
def test_the_confined_process_reads_the_same(name: str) -> None:
    np.testing.assert_array_equal(read_case(CASES[name]).frf.values, read_case_here(CASES[name]).frf.values)


def test_variables_that_could_be_several_things_are_refused_with_a_proposal() -> None:
    f, h = curves()
    files = matlab(a=f, b=2 * f, p=h[:, :, 0], q=h[:, :, 0])
    with pytest.raises(
        InvalidInputError, match=r"a \(float64, 1 x 401\).*proposed: variables=\{\"freq\": \"a\""
    ) as caught:
        read_case_here(Case("", files, f, h))
    assert caught.value.context["value"] == {"freq": "a", "values": "p"}


def test_columns_that_could_be_several_things_are_refused_with_a_proposal() -> None:
    f, h = curves()
    content = table([f, np.abs(h[:, 0, 0]), np.angle(h[:, 0, 0])])
    with pytest.raises(InvalidInputError, match="3 columns of 401 rows; proposed"):
        read_case_here(Case("", (("a.csv", content),), f, h))


def test_what_nobody_declares_is_assumed_and_said() -> None:
    f, h = curves()
    file = io.BytesIO(npz(freq=f, values=h)[0][1])
    declared = DeclaredTest(averages=7, window="exponential")
    measurement = read_measurement(file, None, largest=10**8, declared=declared)
    assert [a.quantity for a in measurement.assumed] == [
        "unit",
        "outputs",
        "inputs",
        "random_error",
        "exciter",
        "window_end",
        "excitation",
    ]
    assert (measurement.averages, measurement.setup.analyser.window) == (7.0, "exponential")


def test_coherence_of_zeros_is_unknown_and_noted() -> None:
    measurement = read_case_here(CASES["npz, coherence of zeros"])
    assert measurement.coherence is None
    assert "coherence is 0 everywhere, and taken as unknown" in measurement.notes


def test_the_confined_process_hands_on_what_is_wrong() -> None:
    f, h = curves()
    files = matlab(a=f, b=2 * f, p=h[:, :, 0], q=h[:, :, 0])
    with pytest.raises(InvalidInputError, match="proposed: variables") as caught:
        read_case(Case("", files, f, h))
    assert caught.value.context["field"] == "variables"
