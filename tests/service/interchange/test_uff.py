"""Universal files: what goes out comes back, what others write is read, what is damaged is refused."""

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import pyuff
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange import uff
from modallab.interchange.file_content import FileContent
from modallab.interchange.measured import NO_COHERENCE
from modallab.interchange.settings import UNIVERSAL
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.reading import read_here
from tests.rigs import rig

LIMIT = 200_000_000
OUTPUTS = (Dof(1, "Y"), Dof(12, "Z", -1), Dof(5, "X"))
DRIVE = Dof(1, "Y", -1)
NUMBERS = {FrfKind.RECEPTANCE: 8, FrfKind.MOBILITY: 11, FrfKind.INERTANCE: 12}


def measured(kind: FrfKind = FrfKind.INERTANCE, n: int = 33, top: float = 64.0) -> Measurement:
    """A measurement of three responses with all that belongs to it."""
    rng = np.random.default_rng(7)
    values = rng.normal(size=(n, 3, 1)) + 1j * rng.normal(size=(n, 3, 1))
    return Measurement(
        FrfSet(np.linspace(0.0, top, n), values, OUTPUTS, (DRIVE,), kind),
        rng.uniform(size=(n, 3)),
        100.0,
        rig(1, 5, analyser={"frequency_max": top, "n_lines": n}),
        rng.uniform(size=(n, 3, 1)),
        rng.uniform(size=(n, 3)),
    )


def read(payload: bytes) -> FileContent:
    """Return what a file holds."""
    return uff.read(payload, largest=LIMIT)


def taken(payload: bytes, setup: RigSetup, averages: float | None = None) -> Measurement:
    """Return the measurement that a file makes on a rig."""
    return read_here(payload, setup, averages=averages, largest=LIMIT)


@pytest.mark.parametrize("kind", list(FrfKind))
def test_what_is_written_is_read_with_equal_arrays(kind: FrfKind) -> None:
    given_ = measured(kind)
    back = read(uff.write(given_))
    assert (back.frf.outputs, back.frf.inputs, back.frf.kind) == (OUTPUTS, (DRIVE,), kind)
    np.testing.assert_array_equal(back.frf.freq, given_.frf.freq)
    np.testing.assert_array_equal(back.frf.values, given_.frf.values)
    for name in ("coherence", "force_spectrum", "response_spectrum"):
        np.testing.assert_array_equal(getattr(back, name), getattr(given_, name), err_msg=name)
    assert back.notes == ()


def test_one_force_serves_all_responses_of_one_run() -> None:
    first = measured()
    assert first.force_spectrum is not None
    force = np.repeat(first.force_spectrum[:, :1], 3, axis=1)
    alike = Measurement(first.frf, None, 100.0, first.setup, force)
    assert uff.write(alike).count(b"N^2/Hz") == 1
    back = read(uff.write(alike))
    np.testing.assert_array_equal(back.force_spectrum, force)
    assert back.coherence is None
    assert back.response_spectrum is None


@pytest.mark.parametrize("kind", list(FrfKind))
def test_pyuff_reads_the_same_from_what_is_written(kind: FrfKind, tmp_path: Path) -> None:
    given_ = measured(kind)
    (tmp_path / "out.uff").write_bytes(uff.write(given_))
    header, units, *sets = pyuff.UFF(str(tmp_path / "out.uff")).read_sets()
    assert (header["type"], units["type"], units["units_code"]) == (151, 164, 1)
    assert (units["length"], units["force"]) == (1.0, 1.0)  # SI
    frfs = [one for one in sets if one["func_type"] == 4]
    assert [(one["rsp_node"], one["rsp_dir"]) for one in frfs] == [(1, 2), (12, -3), (5, 1)]
    assert {(one["ref_node"], one["ref_dir"]) for one in frfs} == {(1, -2)}
    assert {(one["ordinate_spec_data_type"], one["orddenom_spec_data_type"]) for one in frfs} == {
        (NUMBERS[kind], 13)
    }
    unit = {FrfKind.RECEPTANCE: "m", FrfKind.MOBILITY: "m/s", FrfKind.INERTANCE: "m/s^2"}[kind]
    assert {(one["ordinate_axis_units_lab"], one["orddenom_axis_units_lab"]) for one in frfs} == {(unit, "N")}
    autos = [one for one in sets if one["func_type"] == 2]
    forces = [one for one in autos if one["ordinate_spec_data_type"] == 13]
    responses = [one for one in autos if one["ordinate_spec_data_type"] != 13]
    found = {
        "values": (given_.frf.values[:, :, 0], frfs),
        "coherence": (given_.coherence, [one for one in sets if one["func_type"] == 6]),
        "force": (given_.force_spectrum[:, :, 0], forces),  # type: ignore[index]
        "response": (given_.response_spectrum, responses),
    }
    for name, (wanted, those) in found.items():
        np.testing.assert_array_equal(np.stack([one["data"] for one in those], axis=1), wanted, err_msg=name)
    for one in sets:
        np.testing.assert_array_equal(one["x"], given_.frf.freq)
        assert one["n_bytes"] == one["data"].nbytes  # readers of other makers skip by it


def several(exciter: Literal["shaker", "hammer"], n: int = 33) -> Measurement:
    """Three responses to two drives: shakers at once, or a hammer at one after the other."""
    rng = np.random.default_rng(9)
    setup = rig(1, 5, 12, analyser={"frequency_max": 64.0, "n_lines": n})
    drives = (Dof(1, "Y"), Dof(5, "Y", -1))
    setup = replace(setup, drives=drives, exciter=replace(setup.exciter, kind=exciter))
    values = rng.normal(size=(n, 3, 2)) + 1j * rng.normal(size=(n, 3, 2))
    own = (n, 3, 2) if exciter == "hammer" else (n, 3)
    frf = FrfSet(setup.analyser.freq, values, setup.responses, drives, FrfKind.MOBILITY)
    force, response = rng.uniform(size=(n, 3, 2)), rng.uniform(size=own)
    return Measurement(frf, rng.uniform(size=own), 100.0, setup, force, response)


@pytest.mark.parametrize("exciter", ["shaker", "hammer"])
def test_frfs_of_several_drives_come_back_with_all_that_belongs_to_them(
    exciter: Literal["shaker", "hammer"],
) -> None:
    given_ = several(exciter)
    test = taken(uff.write(given_), given_.setup)
    assert (test.frf.outputs, test.frf.inputs) == (given_.frf.outputs, given_.frf.inputs)
    np.testing.assert_array_equal(test.frf.values, given_.frf.values)
    for name in ("coherence", "force_spectrum", "response_spectrum"):
        np.testing.assert_array_equal(getattr(test, name), getattr(given_, name), err_msg=name)
    assert test.notes == ("imported",)


def test_several_drives_at_once_have_multiple_coherence_for_pyuff(tmp_path: Path) -> None:
    given_ = several("shaker")
    (tmp_path / "out.uff").write_bytes(uff.write(given_))
    sets = pyuff.UFF(str(tmp_path / "out.uff")).read_sets()[2:]
    frfs = [one for one in sets if one["func_type"] == 4]
    ends = [tuple(one[name] for name in ("rsp_node", "rsp_dir", "ref_node", "ref_dir")) for one in frfs]
    assert ends == [(node, 2, *source) for node in (1, 5, 12) for source in ((1, 2), (5, -2))]
    np.testing.assert_array_equal(
        np.stack([one["data"] for one in frfs], axis=1).reshape(-1, 3, 2), given_.frf.values
    )
    multiple = [one for one in sets if one["func_type"] == 26]
    np.testing.assert_array_equal(np.stack([one["data"] for one in multiple], axis=1), given_.coherence)


def test_a_force_a_drive_serves_all_responses_of_one_run() -> None:
    given_ = several("shaker")
    assert given_.force_spectrum is not None
    alike = replace(given_, force_spectrum=np.repeat(given_.force_spectrum[:, :1], 3, axis=1))
    payload = uff.write(alike)
    assert payload.count(b"N^2/Hz") == 2
    np.testing.assert_array_equal(taken(payload, alike.setup).force_spectrum, alike.force_spectrum)


def test_a_spacing_of_many_digits_is_kept() -> None:
    given_ = measured(n=802, top=800.0)
    # 13 columns hold ten digits of the spacing or more
    np.testing.assert_allclose(read(uff.write(given_)).frf.freq, given_.frf.freq, rtol=1e-9)


def test_a_file_becomes_a_measurement_on_the_rig_with_its_averages() -> None:
    n = 33
    setup = rig(1, 5, 9, analyser={"frequency_max": 64.0, "n_lines": n, "averages": 40})
    frf = FrfSet(
        setup.analyser.freq,
        np.ones((n, 2, 1), complex),
        setup.responses[:2],
        (setup.drive,),
        FrfKind.MOBILITY,
    )
    payload = uff.write(Measurement(frf, None, 7.0, setup))
    test = taken(payload, setup)
    assert (test.averages, test.setup.responses) == (40.0, setup.responses[:2])
    assert test.notes == ("imported", NO_COHERENCE)
    assert taken(payload, setup, averages=12.5).averages == 12.5
    with pytest.raises(InvalidInputError, match="drives elsewhere"):
        taken(uff.write(measured()), setup)


# --- files of other makers -------------------------------------------------------------------------

FREQ = np.arange(25) * 0.78125
RNG = np.random.default_rng(3)
CURVES = {node: RNG.normal(size=25) + 1j * RNG.normal(size=25) for node in (1, 2, 3)}


def function(node: int, **changed: Any) -> dict[str, Any]:
    """An FRF, inertance at a node, as pyuff has it."""
    fields: dict[str, Any] = {
        "binary": 0,
        "func_type": 4,
        "rsp_node": node,
        "rsp_dir": 3,
        "ref_node": 1,
        "ref_dir": 3,
        "data": CURVES[node],
        "x": FREQ,
        "abscissa_spacing": 1,
        "abscissa_spec_data_type": 18,
        "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 13,
    }
    return dict(pyuff.prepare_58(**(fields | changed)))


def coherence(node: int) -> dict[str, Any]:
    """The coherence of that FRF."""
    data = np.full(25, 0.9) + 0.01 * node
    return function(
        node, func_type=6, data=data, ord_data_type=2, ordinate_spec_data_type=0, orddenom_spec_data_type=0
    )


def force(**changed: Any) -> dict[str, Any]:
    """The auto spectrum of the force."""
    fields = {"func_type": 2, "data": np.full(25, 3.0), "ordinate_spec_data_type": 13, "ver_num": 1}
    return function(
        1, **(fields | {"ordinate_axis_units_lab": "N^2/Hz", "orddenom_spec_data_type": 0} | changed)
    )


@pytest.fixture
def foreign(tmp_path: Path) -> Callable[..., bytes]:
    """Return how pyuff writes datasets."""

    def written(*sets: dict[str, Any], double: bool = True) -> bytes:
        path = tmp_path / "foreign.uff"
        path.unlink(missing_ok=True)
        for one in sets:
            pyuff.UFF(str(path)).write_sets([one], "add", force_double=double)
        return path.read_bytes()

    return written


DIALECTS: dict[str, tuple[dict[str, Any], bool]] = {
    "text, double": ({}, True),
    "text, single": ({"ord_data_type": 5}, False),
    "text, uneven axis": ({"abscissa_spacing": 0}, True),
    "text, single, uneven axis": ({"abscissa_spacing": 0, "ord_data_type": 5}, False),
    "binary": ({"binary": 1}, True),
    "binary, uneven axis": ({"binary": 1, "abscissa_spacing": 0}, True),
}


# pyuff leaves files open when it writes binary data
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("ends", [b"\n", b"\r\n", b"      \n"])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_are_read(foreign: Callable[..., bytes], dialect: str, ends: bytes) -> None:
    changed, double = DIALECTS[dialect]
    nodes = {"type": 15, "node_nums": [1.0, 2.0], "x": [0.0, 1.0], "y": [0.0, 0.0], "z": [0.0, 0.0]}
    nodes |= {"def_cs": [0, 0], "disp_cs": [0, 0], "color": [0, 0]}
    sets = [function(3, **changed), function(1, **changed), coherence(3), coherence(1)]
    payload = foreign(nodes, coherence(2), *sets, function(2, **changed), double=double)
    if not changed.get("binary"):
        payload = payload.replace(b"\n", ends)
    back = read(payload)
    assert back.frf.kind is FrfKind.INERTANCE
    assert back.frf.outputs == (Dof(3, "Z"), Dof(1, "Z"), Dof(2, "Z"))
    wanted = np.stack([CURVES[node] for node in (3, 1, 2)], axis=1)[:, :, None]
    # six digits in single precision, twelve in double
    np.testing.assert_allclose(back.frf.values, wanted, rtol=1e-11 if double else 2e-5)
    np.testing.assert_allclose(back.frf.freq, FREQ, rtol=1e-5)
    np.testing.assert_allclose(back.coherence, np.tile([0.93, 0.91, 0.92], (25, 1)))  # type: ignore[arg-type]


def test_a_binary_file_of_single_precision_in_the_other_byte_order_is_read() -> None:
    payload = uff.write(measured())
    values = measured().frf.values[:, 0, 0]
    head, _, _ = payload.partition(values.tobytes())
    head = head.replace(
        b"58b     1     2          11         528", b"58b     2     2          11         264"
    )
    head = head.replace(b"record 1 of 12", b"")
    head = head.replace(b"         6        33", b"         5        33")
    big = np.stack([values.real, values.imag], axis=1).astype(">f4").tobytes()
    for end in (b"    -1\n", b"\n    -1\n", b"\r\n    -1\r\n", b"    -1"):
        np.testing.assert_allclose(read(head + big + end).frf.values[:, 0, 0], values, rtol=1e-7)


BESIDE = """
   151
Model of another program
NONE
Analyser Rev 15A
11-Oct-17 09:34:21
11-Oct-17 09:34:21
Analyser Rev 15A
17-Oct-17 13:50:13
    -1
    -1
   164
         9USER_DEFINED
  1.00000000000000000D+00  1.00000000000000000D+00  1.00000000000000000D+00
 -2.73149999999999960D+02
    -1
    -1
    18
         1         0         0         8         1
SYS1
 -2.40000e+00 -9.50000e-01  0.00000e+00 -3.40000e+00 -9.50000e-01 -8.74228e-08
 -3.40000e+00 -9.50000e-01 -1.00000e+00
    -1
    -1
    82
         1         3         8
Ground
         2         0         3
    -1
    -1
    58
1x : m/s²
NONE
30-Apr-20 19:12:52
NONE
NONE
    1         0    0         0 NONE               0   0 NONE               0   0
         2         7         1 0.00000E+000 5.00000E-005 0.00000E+000
        17    0    0    0 Time                 s
         1    0    0    0 1x                   m/s²
         0    0    0    0 NONE                 NONE
         0    0    0    0 NONE                 NONE
 -3.81956E+00 -3.56616E+00 -2.98987E+00 -2.62207E+00 -3.22879E+00 -3.63712E+00
 -3.90210E+00
    -1
    -1
    58
Power Spectral Density (PSD)
NONE
NONE
NONE
NONE
    9         0    0         0 Pilot 1            0   0 NONE               0   0
         5         3         0 0.000000E+00 0.000000E+00 0.000000E+00
         0    0    0    0 Hz                   Hz
         0    0    0    0 g²/Hz                g²/Hz
         0    0    0    0 NONE                 NONE
         0    0    0    0 NONE                 NONE
 0.000000E+00 0.000000E+00 0.000000E+00 1.000000E+00 1.255863E-06 0.000000E+00
 2.000000E+00 4.311770E-07 0.000000E+00
    -1
"""


@pytest.mark.parametrize("blanks", [0, 74])
def test_what_acquisition_systems_put_beside_frfs_passes_by(
    foreign: Callable[..., bytes], blanks: int
) -> None:
    beside = ("    -1" + BESIDE).replace("    -1\n", "    -1" + " " * blanks + "\n")
    back = read(beside.encode() + foreign(function(1)))
    np.testing.assert_allclose(back.frf.values[:, 0, 0], CURVES[1], rtol=1e-11)
    assert back.notes == ("written by Analyser Rev 15A",)


TIME = {"func_type": 1, "abscissa_spec_data_type": 17}


# pyuff leaves files open when it writes binary data
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("binary", [0, 1])
def test_a_long_record_beside_frfs_passes_by_whatever_its_length(
    foreign: Callable[..., bytes], binary: int
) -> None:
    count = UNIVERSAL.max_lines + 7
    record = function(1, data=np.ones(count), x=np.arange(count) * 1e-4, binary=binary, **TIME)
    back = read(foreign(record, function(1), record))
    np.testing.assert_allclose(back.frf.values[:, 0, 0], CURVES[1], rtol=1e-11)


def test_a_file_without_frfs_is_refused_with_what_it_holds(foreign: Callable[..., bytes]) -> None:
    record = function(1, data=np.ones(25), **TIME)
    line = b"    -1\n    82\n         1         2         8\nGround\n         1         2\n    -1\n"
    told = r"trace lines \(82\), 2 time responses \(58\), coherences \(58\)"
    with pytest.raises(InvalidInputError, match=told):
        read(line + foreign(record, coherence(1), record))


def test_a_value_that_is_no_number_is_refused_with_its_line(foreign: Callable[..., bytes]) -> None:
    value = measured().frf.values[3, 0, 0].tobytes()
    with pytest.raises(InvalidInputError, match=r"at line 4 \(6 Hz\)"):
        read(uff.write(measured()).replace(value, np.array([np.nan, 0]).tobytes()))
    text = foreign(function(1)).split(b"\n")
    text[-5] = b" NaN" + text[-5][4:]
    with pytest.raises(InvalidInputError, match=r"dataset 1 .* row 11 "):  # of 13
        read(b"\n".join(text))


def test_a_rounded_spacing_is_taken_for_the_analysers(foreign: Callable[..., bytes]) -> None:
    spacing = 0.1953125  # written as 1.95312e-01
    payload = foreign(function(1, x=np.arange(25) * spacing, ref_dir=2, rsp_dir=2))
    setup = rig(1, analyser={"frequency_max": 24 * spacing, "n_lines": 25})
    test = taken(payload, setup)
    np.testing.assert_array_equal(test.frf.freq, setup.analyser.freq)


def test_units_that_the_file_declares_are_converted(foreign: Callable[..., bytes]) -> None:
    units = {"type": 164, "units_code": 5, "units_description": "mm (milli-newton)", "temp_mode": 1}
    units |= {"length": 1e3, "force": 1e3, "temp": 1.0, "temp_offset": 273.15}
    sets = [function(2, ordinate_axis_units_lab="mm/s^2", orddenom_axis_units_lab="mN", ver_num=1)]
    back = read(foreign(units, *sets, force(ordinate_axis_units_lab="mN^2/Hz")))
    np.testing.assert_allclose(back.frf.values[:, 0, 0], CURVES[2], rtol=1e-11)  # (mm/s^2)/mN is SI
    np.testing.assert_allclose(back.force_spectrum, 3e-6)  # type: ignore[arg-type]


def test_what_does_not_belong_to_every_frf_is_left_out_and_noted(foreign: Callable[..., bytes]) -> None:
    frfs = [function(1), function(2)]
    assert read(foreign(*frfs, coherence(2))).notes == ("coherence left out: not there for every FRF",)
    (note,) = read(foreign(*frfs, force(), force())).notes
    assert "not clear" in note
    (note,) = read(foreign(*frfs, force(ordinate_axis_units_lab="N^2"))).notes
    assert "per Hz" in note


NO_MEASUREMENT: dict[str, tuple[list[dict[str, Any]], str]] = {
    "no FRF": ([coherence(1)], "file"),
    "time signals only": ([function(1, data=np.ones(25), **TIME)], "file"),
    "a reference without all responses": ([function(1), function(2, ref_node=2)], "inputs"),
    "one response twice": ([function(1), function(1)], "outputs"),
    "motion per motion": ([function(1, orddenom_spec_data_type=12)], "kind"),
    "two kinds": ([function(1), function(2, ordinate_spec_data_type=8)], "kind"),
    "no direction": ([function(1, rsp_dir=0)], "file"),
    "multiples of g": ([function(1, ordinate_axis_units_lab="g/N")], "units"),
    "two axes": ([function(1), function(2, x=FREQ * 2)], "freq"),
    "a falling axis": ([function(1, x=-FREQ)], "freq"),
}


@pytest.mark.parametrize("case", NO_MEASUREMENT)
def test_functions_that_make_no_measurement_are_refused(foreign: Callable[..., bytes], case: str) -> None:
    sets, field = NO_MEASUREMENT[case]
    with pytest.raises(InvalidInputError) as caught:
        read(foreign(*sets))
    assert caught.value.context["field"] == field


def test_frfs_of_other_quantities_are_refused_with_what_they_are(foreign: Callable[..., bytes]) -> None:
    told = r"they are general per unknown, by their labels '\(1/N\)\*\(m/s2\)'"
    kind = {"ordinate_spec_data_type": 1, "orddenom_spec_data_type": 0}
    with pytest.raises(InvalidInputError, match=told):
        read(foreign(function(1, ordinate_axis_units_lab="(1/N)*(m/s2)", **kind)))
    with pytest.raises(InvalidInputError, match="displacement per force, acceleration per force"):
        read(foreign(function(1), function(2, ordinate_spec_data_type=8)))


def test_a_file_that_is_too_large_says_what_may_be_left_out_of_it() -> None:
    with pytest.raises(InvalidInputError, match=r"larger than 100 MB; .* time records"):
        read(b"    -1\n    58\n".ljust(UNIVERSAL.max_bytes + 1))


# --- damaged files ---------------------------------------------------------------------------------

WHOLE = uff.write(measured())


@given(st.integers(0, len(WHOLE) - 2))
@settings(max_examples=150, deadline=None)
def test_a_file_cut_anywhere_is_refused(length: int) -> None:
    with pytest.raises(InvalidInputError):
        taken(WHOLE[:length], measured().setup)


def test_without_its_last_line_end_a_file_is_whole() -> None:
    np.testing.assert_array_equal(read(WHOLE[:-1]).frf.values, measured().frf.values)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_a_text_file_cut_within_a_dataset_is_refused(data: st.DataObject) -> None:
    cut = data.draw(st.integers(0, len(TEXT) - 2))
    with pytest.raises(InvalidInputError):
        read(TEXT[:cut])


@given(st.binary(max_size=200), st.integers(0, len(WHOLE) - 1))
@settings(max_examples=100, deadline=None)
def test_a_file_with_other_bytes_in_it_is_read_or_refused_by_name(noise: bytes, at: int) -> None:
    try:
        read(WHOLE[:at] + noise + WHOLE[at + len(noise) :])
    except InvalidInputError as error:
        assert error.context["field"]  # noqa: PT017


def text_file(values: str = " 1.00000E+00", count: int = 6, rows: int = 2, form: int = 5) -> bytes:
    """One FRF as text, single precision."""
    header = [
        "    -1",
        "    58",
        *["NONE"] * 5,
        "    4         0    0         0 NONE               1   2 NONE               1   2",
        f"{form:10d}{count:10d}         1  0.00000E+00  1.00000E+00  0.00000E+00",
        "        18    0    0    0 NONE                 Hz",
        "        12    0    0    0 NONE                 m/s^2",
        "        13    0    0    0 NONE                 N",
        "         0    0    0    0 NONE                 NONE",
    ]
    return "\n".join([*header, *[f"{values:>13}" * 6] * rows, "    -1", ""]).encode()


TEXT = text_file()


@pytest.mark.parametrize(
    "header",
    [
        "NONE".ljust(80).encode(),
        "acceleration (m/s²)".encode(),
        "acceleration (m/s²)".encode("latin-1"),
        b"[.../Wet 36V 1/1 :1]    -1",
        b"",
        b"x" * 120,
        b"a\x0bb\x0cc\x1cd",
    ],
)
def test_what_others_write_in_the_first_lines_does_no_harm(header: bytes) -> None:
    payload = TEXT.replace(b"NONE\n", header + b"\n", 3)
    np.testing.assert_array_equal(read(payload).frf.values, np.full((6, 1, 1), 1 + 1j))


def test_exponents_of_fortran_are_read() -> None:
    np.testing.assert_array_equal(read(text_file("1.0D+00")).frf.values, np.full((6, 1, 1), 1 + 1j))


HOSTILE: dict[str, bytes] = {
    "nothing": b"",
    "no universal file": b"freq,values\n1,2\n",
    "the beginning of one": b"    -1\n",
    "NaN as text": text_file("NaN"),
    "infinity as text": text_file("Infinity"),
    "too large for a double": text_file("1.0E+999"),
    "commas": text_file("1.0E+00,"),
    "decimal commas": text_file("1,0E+00"),
    "semicolons": text_file("1.0E+00;"),
    "tabs": text_file("1.0E+00\t"),
    "two numbers in a column": text_file("1.0 2.0"),
    "more values than lines": text_file(count=60_000),
    "1 GB declared as text": text_file(count=10**9 // 8),
    "1 GB declared, binary": WHOLE.replace(b"        33         1", b" 125000000         1", 1),
    "a negative count": text_file(count=-6),
    "a data form of its own": text_file(form=9),
    "NaN, binary": WHOLE.replace(measured().frf.values[3, 0, 0].tobytes(), np.array([np.nan, 0]).tobytes()),
    "other floating-point numbers": WHOLE.replace(b"58b     1     2", b"58b     1     1"),
    "units that are none": b"    -1\n\r  164\n         1\n    -1\n" + TEXT,
    "units of zero": b"    -1\n   164\n         1\n 0.0 1.0 1.0 1.0\n    -1\n" + TEXT,
    "two files in one": WHOLE * 2,
    "24 MB of line ends": b"    -1\n    58" + b"\r\n" * 11_900_000,
    "24 MB of line ends in an unknown dataset": b"    -1\n    15" + b"\n" * 22_980_000 + b"\n    -1\n",
    "24 MB of marks": b"    -1\n    15\n    -1\n" * 1_140_000,
    "24 MB of half marks": b"    -1\n    15\n" + b"    -1x\n" * 2_980_000,
    "24 MB of numbers in one dataset": text_file(rows=300_000),
    "24 MB of good functions, the last one cut": (text_file(count=60_000, rows=20_000) * 15)[:-9],
    "200 MB": bytes(200_000_000),
    "200 MB that begin well": b"    -1\n    58\n".ljust(200_000_000),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused_in_little_memory(case: str) -> None:
    setup, payload = measured().setup, HOSTILE[case]
    with pytest.raises(InvalidInputError) as caught:
        taken(payload, setup)
    assert caught.value.context["field"] in ("file", "outputs")
    tracemalloc.start()
    with pytest.raises(InvalidInputError):
        taken(payload, setup)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200_000_000


# Nothing is wrong with any function by itself, so all are read before the file is refused.
LATE = {
    "24 MB of functions of one response": text_file(count=60_000, rows=20_000) * 15,
    "6,000 functions of one response": text_file() * 6_000,
}


@pytest.mark.parametrize("case", LATE)
def test_a_file_whose_end_is_wrong_is_refused_as_a_whole(case: str) -> None:
    with pytest.raises(InvalidInputError, match="twice"):
        taken(LATE[case], measured().setup)
