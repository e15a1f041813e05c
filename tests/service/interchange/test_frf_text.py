"""The thesis program's text layout: what goes out comes back, what is damaged is refused."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange import frf_text
from modallab.interchange.file_content import FileContent
from modallab.interchange.settings import FRF_TEXT_FILE
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.reading import read_here
from tests.rigs import rig
from tests.service.interchange.test_uff import DRIVE, OUTPUTS, measured

LIMIT = 200_000_000


def read(payload: bytes) -> FileContent:
    """Return what a file holds."""
    return frf_text.read(payload, largest=LIMIT)


def taken(payload: bytes, setup: RigSetup) -> Measurement:
    """Return the measurement that a file makes on a rig."""
    return read_here(payload, setup, largest=LIMIT)


@pytest.mark.parametrize("kind", list(FrfKind))
def test_with_all_digits_what_is_written_is_read_with_equal_arrays(kind: FrfKind) -> None:
    given_ = measured(kind)
    back = read(frf_text.write(given_, FRF_TEXT_FILE.all_decimals))
    assert (back.frf.outputs, back.frf.inputs, back.frf.kind) == (OUTPUTS, (DRIVE,), kind)
    np.testing.assert_array_equal(back.frf.freq, given_.frf.freq)
    np.testing.assert_array_equal(back.frf.values, given_.frf.values)
    # a number below 1 has 16 digits behind the point: 17 are needed for the last bit
    np.testing.assert_allclose(back.coherence, given_.coherence, rtol=0, atol=1e-16)  # type: ignore[arg-type]


def test_the_columns_of_the_program_keep_four_digits() -> None:
    given_ = measured()
    back = read(frf_text.write(given_))
    for part in (np.real, np.imag):
        np.testing.assert_allclose(part(back.frf.values), part(given_.frf.values), rtol=5.0001e-4)
    np.testing.assert_allclose(back.coherence, given_.coherence, atol=5.0001e-4)  # type: ignore[arg-type]


def test_the_columns_are_those_of_the_program() -> None:
    lines = frf_text.write(measured()).decode().splitlines()
    assert lines[1] == " 3"
    assert lines[2] == "          33     0.000     2.000"  # 7X, I5, 2F10.3
    assert lines[3] == " 1"
    assert [int(field) for field in lines[4].split()] == [1, -2, 1, 2, 0]  # drive, response
    assert lines[6].split() == ["2", "2"]
    assert {len(line) for line in lines[7:15]} == {80}  # 8E10.3
    assert len(lines[16]) == 71  # 1X, 10F7.3
    assert (
        lines[20] == "     0.0    2.0    4.0    6.0    8.0   10.0   12.0   14.0   16.0   18.0"
    )  # 1X, 10F7.1
    assert lines[24].startswith("modallab, FRF 2 of 3: 12:-Z / 1:-Y")


def test_a_file_becomes_a_measurement_with_the_rigs_axis_and_averages() -> None:
    top = 32 * 0.1953125  # its spacing is written as 0.195
    setup = rig(1, 5, analyser={"frequency_max": top, "n_lines": 33, "averages": 40})
    frf = replace(
        measured().frf,
        freq=setup.analyser.freq,
        outputs=setup.responses,
        inputs=setup.drives,
        values=measured().frf.values[:, :2],
    )
    payload = frf_text.write(Measurement(frf, None, 7.0, setup))
    test = taken(payload, setup)
    np.testing.assert_array_equal(test.frf.freq, setup.analyser.freq)
    assert (test.averages, test.coherence, test.setup.responses) == (40.0, None, setup.responses)


def block(
    values: str = " 0.100E+01-0.200E+00",
    flag: int = 0,
    n: int = 12,
    listed: str = "",
    kind: int = 3,
    start: float = 0.0,
) -> str:
    """One FRF as the program writes it: columns that touch, the last row of frequencies filled up."""
    per_row = [values * min(4, n - at) for at in range(0, n, 4)]
    rows = -(-n // 10)
    freq = [start + 2.0 * i for i in range(10 * rows)]
    table = ["".join(f"{one:7.1f}" for one in freq[10 * i : 10 * i + 10]) for i in range(rows)]
    lines = [
        "FREE-FREE BEAM",
        f"           {kind}",
        f"       {n:5d}{start:10.3f}     2.000",
        f"           {flag}",
        "           1           2           5           2           0",
        "  0 0 0 0 0",
        "           1           9",
        *per_row,
        *([" " + "  0.900" * min(10, n - 10 * i) for i in range(rows)] if flag else []),
        *([listed] if listed else [" " + row for row in table]),
        "",
    ]
    return "\n".join(lines)


def test_a_file_of_the_program_is_read() -> None:
    for ends in ("\n", "\r\n", "   \n"):
        back = read(block(flag=1).replace("\n", ends).encode())
        assert (back.frf.kind, back.frf.outputs, back.frf.inputs) == (
            FrfKind.INERTANCE,
            (Dof(5, "Y"),),
            (Dof(1, "Y"),),
        )
        np.testing.assert_array_equal(back.frf.freq, 2.0 * np.arange(12))
        np.testing.assert_array_equal(back.frf.values, np.full((12, 1, 1), 1.0 - 0.2j))
        np.testing.assert_array_equal(back.coherence, np.full((12, 1), 0.9))


def test_numbers_with_blanks_between_and_exponents_of_fortran_are_read() -> None:
    back = read(block("  0.1D+01  -2.0E-1").replace("0.000     2.000", "0.  .2D+01").encode())
    np.testing.assert_array_equal(back.frf.values, np.full((12, 1, 1), 1.0 - 0.2j))


def test_frequencies_that_touch_from_10000_hz_are_read() -> None:
    text = block(n=30, start=9980.0)
    assert "10000.010002.0" in text
    np.testing.assert_array_equal(read(text.encode()).frf.freq, 9980 + 2.0 * np.arange(30))


def test_coherence_that_not_every_frf_has_is_left_out_and_noted() -> None:
    other = block().replace("5           2           0", "7           2           0")
    back = read((block(flag=1) + other).encode())
    assert back.frf.outputs == (Dof(5, "Y"), Dof(7, "Y"))
    assert (back.coherence, len(back.notes)) == (None, 1)


def test_a_roving_hammers_frfs_come_back_with_a_coherence_each() -> None:
    given_ = measured()
    drives = (Dof(1, "Y"), Dof(5, "Y"))
    rng = np.random.default_rng(1)
    setup = replace(given_.setup, drives=drives, responses=OUTPUTS[:1])
    setup = replace(setup, exciter=replace(setup.exciter, kind="hammer"))
    values = rng.normal(size=(33, 1, 2)).astype(complex)
    frf = replace(given_.frf, values=values, inputs=drives, outputs=OUTPUTS[:1])
    test = Measurement(frf, np.round(rng.uniform(size=(33, 1, 2)), 3), 10.0, setup)
    back = taken(frf_text.write(test, FRF_TEXT_FILE.all_decimals), setup)
    np.testing.assert_array_equal(back.frf.values, values)
    np.testing.assert_array_equal(back.coherence, test.coherence)


WHOLE = frf_text.write(measured())


@given(st.integers(0, len(WHOLE) - 1))
@settings(max_examples=150, deadline=None)
def test_a_file_cut_anywhere_is_refused_or_whole(length: int) -> None:
    try:
        back = read(WHOLE[:length])
    except InvalidInputError as error:
        assert error.context["field"]  # noqa: PT017
        return
    # All that may be missing is the last zero of the last frequency, and the line's end.
    assert length >= len(WHOLE) - 3
    np.testing.assert_array_equal(back.frf.values, read(WHOLE).frf.values)


@given(st.binary(min_size=1, max_size=100), st.integers(0, len(WHOLE) - 1))
@settings(max_examples=200, deadline=None)
def test_a_file_with_other_bytes_in_it_is_read_or_refused_by_name(noise: bytes, at: int) -> None:
    try:
        read(WHOLE[:at] + noise + WHOLE[at + len(noise) :])
    except InvalidInputError as error:
        assert error.context["field"]  # noqa: PT017


HOSTILE = {
    "nothing": "",
    "the beginning of one": block()[:60],
    "NaN": block("       NaN-0.200E+00"),
    "infinity": block("  Infinity-0.200E+00"),
    "too large for a double": block(" 0.1E+9999-0.200E+00"),
    "stars for a number too wide": block(" **********0.200E+00"),
    "commas": block(" 1.000E+00,0.200E+0"),
    "decimal commas": block(" 0,100E+01-0,200E+00"),
    "semicolons": block(" 0.100E+01;0.200E+00"),
    "numbers with underscores": block(" 0.1_0E+01-0.20E+00"),
    "another kind": block(kind=4),
    "another coherence flag": block(flag=0).replace("           0\n", "           2\n", 1),
    "coherence declared and missing": block().replace("           0\n", "           1\n", 1),
    "1 GB declared": block().replace("          12 ", "   125000000 "),
    "a negative count": block().replace("          12 ", "         -12 "),
    "a count that is none": block().replace("          12 ", "          ²2 "),
    "a falling axis": block().replace("     2.000", "    -2.000", 1),
    "an axis beyond numbers": block().replace("     2.000", " 0.9E+308", 1),
    "frequencies of another axis": block().replace("     2.000", "     3.000", 1),
    "a direction that does not exist": block().replace("5           2", "5           7"),
    "a node beyond numbers": block().replace("5           2", "9" * 5000 + " 2"),
    "an FRF twice": block() * 2,
    "two kinds": block() + block(kind=1),
    "two axes": block() + block(n=11),
    "24 MB of line ends": block() + "\n" * 22_000_000 + "x",
    "24 MB of one line": block("1 " * 900_000),
    "6,001 FRFs of one response": block() * 6_001,
    "200 MB": block().ljust(200_000_000),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused_in_little_memory(case: str) -> None:
    payload = HOSTILE[case].encode("latin-1")
    setup = rig(5, analyser={"frequency_max": 22.0, "n_lines": 12})
    with pytest.raises(InvalidInputError) as caught:
        taken(payload, setup)
    assert caught.value.context["field"]
    if len(payload) > 10_000_000:
        tracemalloc.start()
        with pytest.raises(InvalidInputError):
            taken(payload, setup)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 200_000_000


def test_21_mb_of_good_frfs_of_one_response_are_refused() -> None:
    payload = (block(n=40_000) * 19).encode()
    with pytest.raises(InvalidInputError, match="twice"):
        read(payload)


def test_decimals_have_bounds() -> None:
    for decimals in (2, 17):
        with pytest.raises(InvalidInputError, match="decimals"):
            frf_text.write(measured(), decimals)
