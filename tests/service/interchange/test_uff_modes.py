"""Mode shapes as universal files: what goes out comes back, what others write is read."""

import io
import tracemalloc
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import pyuff
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode
from modallab.interchange import reading, uff, uff_modes
from modallab.interchange.settings import CONFINEMENT, UNIVERSAL
from modallab.interchange.uff_text import Origin

LIMIT = 200_000_000
DOFS = (Dof(1, "Y"), Dof(12, "Z", -1), Dof(5, "X"), Dof(12, "Y"))
FLAT = (Dof(1, "Y"), Dof(1, "RZ"), Dof(2, "Y"), Dof(2, "RZ"))
FREQUENCIES, LOSS_FACTORS = (22.9473, 63.25, 1240.5), (0.00512, 0.01, 0.3)
# Columns of 13 leave at least six digits, as E13.5 does, and ten without an exponent.
DIGITS = 5e-6


def model(
    dofs: tuple[Dof, ...] = DOFS, is_complex: bool = False, normalisation: Literal["mass", "none"] = "mass"
) -> ModalModel:
    """Three modes."""
    rng = np.random.default_rng(11)
    shapes = rng.normal(size=(3, len(dofs))) + 1j * is_complex * rng.normal(size=(3, len(dofs)))
    modes = tuple(Mode(*one) for one in zip(FREQUENCIES, LOSS_FACTORS, shapes, strict=True))
    return ModalModel(modes, dofs, normalisation, method="dobson")


def read(payload: bytes) -> ModalModel:
    """Return what a file holds, read in this process."""
    return uff_modes.read(payload, largest=UNIVERSAL.max_bytes)


def by_point(of: ModalModel) -> dict[Dof, Any]:
    """Return shape entries by DoF, in its positive sense."""
    return {dof.point: of.shapes[i] * dof.sign for i, dof in enumerate(of.dofs)}


@pytest.mark.parametrize("dofs", [DOFS, FLAT], ids=["translations", "rotations"])
@pytest.mark.parametrize("is_complex", [False, True], ids=["real", "complex"])
@pytest.mark.parametrize("normalisation", ["mass", "none"])
def test_what_is_written_is_read_with_equal_modes(
    dofs: tuple[Dof, ...], is_complex: bool, normalisation: Literal["mass", "none"]
) -> None:
    given_ = model(dofs, is_complex, normalisation)
    back = read(uff_modes.write(given_))
    assert (back.normalisation, back.notes) == (normalisation, ())
    np.testing.assert_allclose(back.frequencies, FREQUENCIES, rtol=DIGITS)
    # the real part of a complex eigenvalue has an exponent: six digits
    np.testing.assert_allclose(back.loss_factors, LOSS_FACTORS, rtol=DIGITS)
    before, after = by_point(given_), by_point(back)
    assert set(before) == set(after)
    for dof, entries in before.items():
        np.testing.assert_allclose(after[dof], entries, rtol=DIGITS, atol=1e-10)


@pytest.mark.parametrize(("dofs", "is_complex"), [(DOFS, False), (DOFS, True), (FLAT, False)])
def test_pyuff_reads_the_same_from_what_is_written(
    dofs: tuple[Dof, ...], is_complex: bool, tmp_path: Path
) -> None:
    given_ = model(dofs, is_complex)
    origin = Origin("a1", "modal model", "0.1", datetime(2026, 3, 5, 7, 8, 9, tzinfo=UTC))
    (tmp_path / "modes.uff").write_bytes(uff_modes.write(given_, origin))
    header, units, *modes = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()
    assert (header["model_name"], header["program"]) == ("a1", "modallab 0.1")
    assert (header["date_db_created"], header["time_db_created"]) == ("05-Mar-26", "07:08:09")
    assert (units["units_code"], units["length"], units["force"]) == (1, 1.0, 1.0)
    assert [one["mode_n"] for one in modes] == [1, 2, 3]
    assert {(one["analysis_type"], one["spec_data_type"]) for one in modes} == {(3 if is_complex else 2, 8)}
    for number, one in enumerate(modes):
        nodes = one["node_nums"].tolist()
        for dof, entries in by_point(given_).items():
            column = one[f"r{('X', 'Y', 'Z', 'RX', 'RY', 'RZ').index(dof.direction) + 1}"]
            np.testing.assert_allclose(column[nodes.index(dof.node)], entries[number], rtol=DIGITS, atol=1e-9)
        if not is_complex:
            assert one["freq"] == pytest.approx(FREQUENCIES[number], rel=1e-9)
            assert (one["modal_m"], one["modal_damp_his"]) == (1.0, LOSS_FACTORS[number])


def test_the_complex_mode_that_is_written_answers_as_the_damped_one(tmp_path: Path) -> None:
    given_ = model(is_complex=True)
    (tmp_path / "modes.uff").write_bytes(uff_modes.write(given_))
    one = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()[2]
    omega = 2 * np.pi * FREQUENCIES[0]
    psi = one["r2"][0]
    viscous = psi**2 / (one["modal_a"] * (1j * omega - one["eig"]))
    viscous += psi**2 / (np.conj(one["modal_a"]) * (1j * omega - np.conj(one["eig"])))
    shape = given_.modes[0].shape[0]
    # At resonance i 2 zeta omega_r^2 = i eta omega_r^2; six digits of a small damping remain.
    assert viscous == pytest.approx(shape**2 / (1j * LOSS_FACTORS[0] * omega**2), rel=1e-4)


# --- files of other makers -------------------------------------------------------------------------


def foreign(tmp_path: Path, *sets: dict[str, Any]) -> bytes:
    """Return how pyuff writes datasets."""
    path = tmp_path / "foreign.uff"
    path.unlink(missing_ok=True)
    pyuff.UFF(str(path)).write_sets(list(sets))
    return path.read_bytes()


NODES = [1, 2, 7]
SHAPE = np.array([1.0, -2.0, 0.5])


def normal(number: int, **changed: Any) -> dict[str, Any]:
    """A normal mode as pyuff has it."""
    fields: dict[str, Any] = {
        "analysis_type": 2,
        "data_ch": 2,
        "spec_data_type": 8,
        "data_type": 2,
        "load_case": 1,
        "mode_n": number,
        "freq": 10.0 * number,
        "node_nums": NODES,
        "r1": np.zeros(3),
        "r2": SHAPE * number,
        "r3": np.zeros(3),
        "modal_m": 4.0,
        "modal_damp_vis": 0.01,
        "modal_damp_his": 0.0,
    }
    return dict(pyuff.prepare_55(**(fields | changed)))


def test_normal_modes_of_pyuff_are_read_and_normalised(tmp_path: Path) -> None:
    back = read(foreign(tmp_path, normal(2), normal(1)))
    assert [str(dof) for dof in back.dofs] == ["1:+Y", "2:+Y", "7:+Y"]
    np.testing.assert_array_equal(back.frequencies, [10.0, 20.0])
    np.testing.assert_array_equal(back.loss_factors, [0.02, 0.02])  # twice the viscous ratio
    np.testing.assert_allclose(back.shapes.T, [SHAPE / 2, SHAPE])  # a modal mass of 4
    assert back.normalisation == "mass"


def test_without_a_modal_mass_shapes_have_any_length(tmp_path: Path) -> None:
    back = read(foreign(tmp_path, normal(1), normal(2, modal_m=0.0)))
    assert back.normalisation == "none"
    np.testing.assert_array_equal(back.shapes.T, [SHAPE, 2 * SHAPE])


def test_hysteretic_damping_goes_before_viscous(tmp_path: Path) -> None:
    assert read(foreign(tmp_path, normal(1, modal_damp_his=0.03))).loss_factors == [0.03]


def test_rotations_and_six_values_a_node_are_read(tmp_path: Path) -> None:
    turned = {"r4": np.zeros(3), "r5": np.zeros(3), "r6": np.array([0.1, 0.2, 0.3])}
    back = read(foreign(tmp_path, normal(1, n_data_per_node=6, data_ch=3, **turned)))
    assert [str(dof) for dof in back.dofs[:2]] == ["1:+Y", "1:+RZ"]
    np.testing.assert_allclose(back.shapes[1::2, 0], np.array([0.1, 0.2, 0.3]) / 2)


def test_units_that_the_file_declares_are_converted(tmp_path: Path) -> None:
    units = {"type": 164, "units_code": 5, "units_description": "mm (milli-newton)", "temp_mode": 1}
    units |= {"length": 1e3, "force": 1e3, "temp": 1.0, "temp_offset": 273.15}
    turned = {"r4": np.zeros(3), "r5": np.zeros(3), "r6": SHAPE}
    mode = normal(1, n_data_per_node=6, **turned)
    plain, converted = read(foreign(tmp_path, mode)), read(foreign(tmp_path, units, mode))
    # mm and mN: the mass unit is mN s^2/mm = kg, and a rotation of 1 rad/mm is 1000 rad/m
    np.testing.assert_allclose(converted.shapes[::2], plain.shapes[::2])
    np.testing.assert_allclose(converted.shapes[1::2], 1e3 * plain.shapes[1::2])
    force = dict(units, force=1.0)  # N and mm: the mass unit is N s^2/mm = 1000 kg
    scaled = read(foreign(tmp_path, force, mode))
    np.testing.assert_allclose(scaled.shapes[::2], plain.shapes[::2] / np.sqrt(1000.0))


def complex_mode(eigenvalue: complex, modal_a: complex, **changed: Any) -> dict[str, Any]:
    """A complex mode as pyuff has it."""
    zeros = np.zeros(3, complex)
    return normal(
        1, analysis_type=3, data_type=5, eig=eigenvalue, modal_a=modal_a, modal_b=0j, r1=zeros, r3=zeros
    ) | {"r2": SHAPE * (1 + 1j), **changed}


def test_complex_modes_come_once_and_without_their_conjugates(tmp_path: Path) -> None:
    omega, ratio = 100.0, 0.02
    eigenvalue = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    modal_a = 2j * eigenvalue.imag * 9.0  # a modal mass of 9
    pair = [complex_mode(eigenvalue, modal_a), complex_mode(np.conj(eigenvalue), np.conj(modal_a))]
    back = read(foreign(tmp_path, *pair))
    assert len(back.modes) == 1
    assert back.frequencies[0] == pytest.approx(omega / (2 * np.pi), rel=1e-5)  # six digits
    assert back.loss_factors[0] == pytest.approx(2 * ratio, rel=1e-5)
    np.testing.assert_allclose(back.shapes[:, 0], SHAPE * (1 + 1j) / 3, rtol=1e-5)
    assert "conjugates" in back.notes[0]


def dialect(*rows: str, kinds: str = "         1         3         2         8         5         3") -> bytes:
    """A complex mode as acquisition systems write it: texts with colons, columns that touch."""
    lines = [
        "    -1".ljust(80),
        "   151",
        *("test", "NONE", "Analyser 15A", "11-Oct-17 09:34:21", "11-Oct-17 09:34:21", "Analyser 15A"),
        "17-Oct-17 13:50:13 ",
        "    -1".ljust(80),
        "    -1".ljust(80),
        "   164",
        "         9USER_DEFINED",
        "  1.00000000000000000D+00  1.00000000000000000D+00  1.00000000000000000D+00",
        " -2.73149999999999960D+02",
        "    -1".ljust(80),
        "    -1",
        "    55",
        *("Test:C1:trans:0321", "FS=  10.00:FE= 20.00", "NM=  5", "d=0.0100:NP=260201+Y"),
        "    999999         3         8        13",
        kinds,
        "         2         6         0         1",
        "-1.000000E-01 4.000000E+01 0.000000E+00 8.000000E+01-1.111110E+05-2.111110E+05",
        *rows,
        "    -1",
        "",
    ]
    return "\n".join(lines).encode()


TOUCHING = (
    "      1101",
    " 0.000000E+00 0.000000E+00-1.500000E-01-9.000000E-02 7.000000E-03-4.000000E-03",
    "       601",
    " 0.000000E+00 0.000000E+00 0.000000E+00 0.000000E+00-4.000000E-02-1.000000E-02",
)


@pytest.mark.parametrize("ends", [b"\n", b"\r\n", b"     \n"])
def test_columns_that_touch_and_headers_of_acquisition_systems_are_read(ends: bytes) -> None:
    back = read(dialect(*TOUCHING).replace(b"\n", ends))
    assert [str(dof) for dof in back.dofs] == ["1101:+Y", "1101:+Z", "601:+Z"]
    assert back.loss_factors[0] == pytest.approx(2 * 0.1 / np.hypot(0.1, 40.0))
    np.testing.assert_allclose(back.shapes[:, 0], [-0.15 - 0.09j, 0.007 - 0.004j, -0.04 - 0.01j])
    assert (back.normalisation, back.notes) == ("mass", ("written by Analyser 15A",))


def test_velocities_and_accelerations_are_not_scaled_by_a_modal_mass_of_displacements() -> None:
    kinds = "         1         3         2        12         5         3"
    assert read(dialect(*TOUCHING, kinds=kinds)).normalisation == "none"


def test_datasets_55_that_hold_no_modes_pass_by(tmp_path: Path) -> None:
    frequency_response = normal(1, analysis_type=5, freq_step_n=1)
    back = read(foreign(tmp_path, frequency_response, normal(3)))
    np.testing.assert_array_equal(back.frequencies, [30.0])


def test_rigid_body_modes_at_0_hz_are_left_out_and_noted(tmp_path: Path) -> None:
    back = read(foreign(tmp_path, normal(1, freq=0.0), normal(2)))
    assert (len(back.modes), len(back.notes)) == (1, 1)


# --- damaged files ---------------------------------------------------------------------------------

WHOLE = uff_modes.write(model(is_complex=True))


@given(st.integers(0, len(WHOLE) - 2))
@settings(max_examples=150, deadline=None)
def test_a_file_cut_anywhere_is_refused(length: int) -> None:
    with pytest.raises(InvalidInputError):
        read(WHOLE[:length])


@given(st.binary(min_size=1, max_size=100), st.integers(0, len(WHOLE) - 1))
@settings(max_examples=200, deadline=None)
def test_a_file_with_other_bytes_in_it_is_read_or_refused_by_name(noise: bytes, at: int) -> None:
    try:
        read(WHOLE[:at] + noise + WHOLE[at + len(noise) :])
    except InvalidInputError as error:
        assert error.context["field"]  # noqa: PT017


def changed(old: str, new: str) -> bytes:
    """Return the dialect above with another record."""
    return dialect(*TOUCHING).replace(old.encode(), new.encode(), 1)


ROW = "       601\n 0.0 0.0 0.0 0.0 1.0 1.0\n"
HOSTILE: dict[str, bytes] = {
    "nothing": b"",
    "no universal file": b"mode,frequency\n1,2\n",
    "no mode": b"    -1\n    15\n         1         0         0         0  0.0  0.0  0.0\n    -1\n",
    "NaN": changed("-1.500000E-01", "          NaN"),
    "infinity": changed("-1.500000E-01", "     Infinity"),
    "too large for a double": changed("-1.500000E-01", "    1.0E+0999"),
    "a decimal comma": changed("-1.500000E-01", "-1,500000E-01"),
    "semicolons": changed("-1.500000E-01", "-1.50000E-01;"),
    "an eigenvalue beyond numbers": changed("-1.000000E-01 4.0", "-9.99999E+307 4.0"),
    "a node that is none": changed("      1101", "      11.1"),
    "a node too large": changed("      1101", "99999999999"),
    "a node twice": changed("       601", "      1101"),
    "a row missing": changed(TOUCHING[1] + "\n", ""),
    "another number of values": changed("         5         3", "         5         6"),
    "a form of its own": changed("         5         3", "         5        21"),
    "no shape at all": dialect(),
    "zeros only": dialect("       601", " 0.0 0.0 0.0 0.0 0.0 0.0"),
    "units of zero": changed("  1.00000000000000000D+00", "  0.00000000000000000D+00"),
    "units of words": changed("  1.00000000000000000D+00", "  one                     "),
    "modes at other nodes": dialect(*TOUCHING) + dialect("       601", " 0.0 0.0 0.0 0.0 1.0 1.0"),
    "24 MB of line ends": b"    -1\n    55" + b"\n" * 22_980_000 + b"\n    -1\n",
    "24 MB of nodes": dialect(ROW * 620_000),
    "24 MB of modes": dialect(*TOUCHING) * 20_000,
    "200 MB": bytes(200_000_000),
    "200 MB that begin well": b"    -1\n    55\n".ljust(200_000_000),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused_in_little_memory(case: str) -> None:
    payload = HOSTILE[case]
    with pytest.raises(InvalidInputError) as caught:
        read(payload)
    assert caught.value.context["field"]
    tracemalloc.start()
    with pytest.raises(InvalidInputError):
        read(payload)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200_000_000


def test_a_file_of_too_many_good_modes_is_refused() -> None:
    rows = (f"{node:10d}\n 0 0 0 0 1 0" for node in range(1000, 5990))
    payload = dialect(ROW.rstrip(), *rows) * 140
    with pytest.raises(InvalidInputError, match="too many modes"):
        read(payload)


def test_a_file_of_frfs_is_no_modal_model() -> None:
    from tests.service.interchange.test_uff import measured

    with pytest.raises(InvalidInputError, match="no mode"):
        read(uff.write(measured()))


def test_another_process_reads_the_same_modes() -> None:
    payload = uff_modes.write(model(is_complex=True, normalisation="none"))
    here, confined = read(payload), reading.read_modal_model(io.BytesIO(payload), largest=LIMIT)
    assert (confined.dofs, confined.normalisation, confined.notes) == (here.dofs, "none", here.notes)
    np.testing.assert_array_equal(confined.shapes, here.shapes)
    np.testing.assert_array_equal(confined.frequencies, here.frequencies)
    np.testing.assert_array_equal(confined.loss_factors, here.loss_factors)


@pytest.mark.parametrize("case", ["NaN", "24 MB of nodes", "no universal file", "200 MB that begin well"])
def test_another_process_refuses_with_the_same_field(case: str) -> None:
    with pytest.raises(InvalidInputError) as here:
        read(HOSTILE[case])
    with pytest.raises(InvalidInputError) as confined:
        reading.read_modal_model(io.BytesIO(HOSTILE[case]), largest=LIMIT)
    assert confined.value.context["field"] == here.value.context["field"]


def test_a_reader_of_modes_that_runs_out_of_memory_harms_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    payload = uff_modes.write(model(tuple(Dof(node, "Y") for node in range(1, 4_000))))
    assert len(read(payload).dofs) == 3_999
    little = replace(CONFINEMENT, memory_bytes=1_000_000, memory_per_byte=0)
    monkeypatch.setattr("modallab.interchange.confinement.CONFINEMENT", little)
    with pytest.raises(InvalidInputError) as caught:
        reading.read_modal_model(io.BytesIO(payload), largest=LIMIT)
    assert caught.value.context["field"] == "file"
