"""`modallab convert`: files of other programs become files that the service takes."""

from pathlib import Path

import numpy as np
from click.testing import CliRunner

from benchmarks.strange_cases import curves, table
from modallab_cli.app import app
from tests.reading import content_here

GRAVITY = 9.80665


def test_a_table_in_g_becomes_a_universal_file_in_si_units(tmp_path: Path) -> None:
    f, h = curves(start=50.0)
    source, out = tmp_path / "wing_tip.csv", tmp_path / "out.uff"
    source.write_bytes(table([f, h[:, 0, 0].real, h[:, 0, 0].imag], "Hz,Re,Im\n"))
    flags = ["--unit", "g/N", "--map", "wing_tip=12:+Z", "--input", "3:-Z"]
    run = CliRunner().invoke(app, ["convert", str(source), str(out), *flags])
    assert run.exit_code == 0, run.output
    assert "assumed averages: 100" in run.output
    frf = content_here(out.read_bytes()).frf
    assert (str(frf.outputs[0]), str(frf.inputs[0])) == ("12:+Z", "3:-Z")
    np.testing.assert_allclose(frf.values, h * GRAVITY, rtol=1e-12)  # double precision in the file


def test_a_fault_ends_with_2_and_says_what_is_allowed(tmp_path: Path) -> None:
    source = tmp_path / "a.csv"
    source.write_bytes(b"1,2\n")
    for out, told in (("b.doc", ".uff"), ("b.uff", "rows of numbers")):
        run = CliRunner().invoke(app, ["convert", str(source), str(tmp_path / out)])
        assert run.exit_code == 2
        assert told in run.output
