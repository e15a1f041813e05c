"""Every script beside the benches explains itself and runs at a small size."""

import importlib
import pkgutil
import sys
from pathlib import Path

import pytest

import benchmarks.__main__ as command
from benchmarks import example_files
from benchmarks.extraction_job import measured
from benchmarks.same_figures import differences

ROOT = Path(command.__file__).parents[1]
SCRIPTS = sorted(
    module.name
    for module in pkgutil.iter_modules([str(ROOT / "benchmarks")])
    if module.name == "__main__" or hasattr(importlib.import_module(f"benchmarks.{module.name}"), "main")
)
SMALL = {
    "averaging_scatter": ["20"],
    "control_bar": ["--members", "26", "--factors", "0.7", "--draws", "1", "--suspects", "stiffness_error"],
    "drawn_against_sampled": ["30"],
    "extraction_accuracy": ["--draws", "1", "--bandwidths", "2"],
    "extraction_errors": ["1"],
    "extraction_job": ["--frfs", "4", "--lines", "801", "--methods", "lscf"],
    "gap_without_cause": ["1"],
    "hammer_modes": ["1", "--points", "20", "--lines", "1601"],
    "laboratory_trial": ["--only", "5", "--suspects", "gain_error", "--workers", "1"],
    "leaked_errors": ["1", "dobson"],
    "measurement_job": ["--rounds", "1", "--jobs", "1"],
    "pair_errors": ["1"],
    "peer_report": ["--small"],
    "resonant_effects": ["--kind", "mounted_resonance", "--count", "1", "--suspects", "mounted_resonance"],
    "strange_files": ["--every", "20"],
    "unknown_effects": ["--kind", "fractional", "--count", "1", "--few"],
    "viscous_modes": ["1"],
    "windowed_errors": ["1", "dobson"],
}
# Minutes at any size; their functions run in `test_benches.py`, below and in `tests/end_to_end`.
ELSEWHERE = {
    "__main__",
    "client_alone",
    "memory",
    "diagnosing",
    "example_files",
    "same_figures",
    "blind_trial",
    "sensitivity",
}
READS_PROC = {"peer_report", "extraction_job", "measurement_job"}


def run(name: str, arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Run a script in this process, as `python -m` does."""
    monkeypatch.setattr(sys, "argv", [name, *arguments])
    importlib.import_module(f"benchmarks.{name}").main()


def test_every_script_is_run() -> None:
    assert set(SCRIPTS) == SMALL.keys() | ELSEWHERE


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_explains_itself(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="0"):
        run(name, ["--help"], monkeypatch)
    assert "usage:" in capsys.readouterr().out


@pytest.mark.parametrize("name", SMALL)
def test_a_script_prints_figures_at_a_small_size(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name in READS_PROC and not Path("/proc/self/status").exists():
        pytest.skip("this system has no /proc")
    run(name, SMALL[name], monkeypatch)
    assert any(character.isdigit() for character in capsys.readouterr().out)


def test_example_files_are_described_and_their_frfs_fitted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _, payload = measured(n_frf=2, n_lines=801)
    monkeypatch.setattr(example_files, "METHODS", ("dobson",))
    plot = tmp_path / "frfs.png"
    example_files.report({example_files.FRFS: payload, "other": b"no measurement"}, plot)
    printed = capsys.readouterr().out
    assert "inertance, 2 responses x 1 references, 801 lines to 800 Hz" in printed
    assert "refused: " in printed
    assert plot.exists()


def test_figures_that_rounding_alone_parts_are_the_same() -> None:
    reference = {"frequency": [100.0, 200.0], "kind": "extra_mass"}
    assert not list(differences(reference, {"frequency": [100.0, 200.0 * (1 + 1e-9)], "kind": "extra_mass"}))
    changed = list(differences(reference, {"frequency": [100.0, 201.0], "kind": "gain_error"}))
    assert sorted(line.partition(":")[0] for line in changed) == ["/frequency", "/kind"]
