"""Every bench runs in its short form; limits are judged by `make bench` alone."""

import importlib
import math
import pkgutil
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import pytest

import benchmarks.__main__ as command
from benchmarks.bench import Bench, Row, benches

FOLDER = Path(command.__file__).parent
BENCHES = benches()


def modules() -> list[ModuleType]:
    """Return all modules beside the benches."""
    names = sorted(module.name for module in pkgutil.iter_modules([str(FOLDER)]) if module.name != "__main__")
    return [importlib.import_module(f"benchmarks.{name}") for name in names]


def declaring(monkeypatch: pytest.MonkeyPatch, **declared: Sequence[Row] | Exception) -> None:
    """Have the command know these benches alone: their rows, or what they raise."""

    def bench(outcome: Sequence[Row] | Exception) -> Bench:
        def form() -> Sequence[Row]:
            if isinstance(outcome, Exception):
                raise outcome
            return outcome

        return Bench(form, form)

    monkeypatch.setattr(command, "benches", lambda: {name: bench(rows) for name, rows in declared.items()})


@pytest.mark.parametrize("name", BENCHES)
def test_the_short_form_gives_finite_figures(name: str) -> None:
    if not BENCHES[name].runs_here:
        pytest.skip("this system has no /proc")
    rows = BENCHES[name].short()
    assert rows
    for label, figure, limit in rows:
        assert math.isfinite(figure), label
        assert math.isfinite(limit), label


def test_every_module_that_makes_figures_declares_a_bench() -> None:
    with_run = {m.__name__ for m in modules() if getattr(vars(m).get("run"), "__module__", "") == m.__name__}
    assert with_run == {f"benchmarks.{name}" for name in BENCHES}


def test_a_bench_that_fails_does_not_stop_the_others(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    declaring(monkeypatch, first=TypeError("no size"), second=[("time over peer", 0.5, 1.0)])
    assert command.main([]) == 1
    printed = capsys.readouterr().out
    assert "time over peer" in printed
    assert printed.endswith("1 faults\n  first: TypeError: no size\n")


def test_limits_are_judged_in_the_full_form_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    declaring(monkeypatch, slow=[("time over peer", 2.0, 1.0)])
    assert command.main([]) == 1
    assert command.main(["--short"]) == 0


@pytest.mark.parametrize("arguments", [[], ["--short"]])
def test_a_figure_that_is_no_number_is_a_fault(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    declaring(monkeypatch, empty=[("time over peer", math.nan, 1.0)])
    assert command.main(arguments) == 1


def test_a_bench_can_be_run_by_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    declaring(monkeypatch, one=[("the one", 0.5, 1.0)], other=[("the other", 0.5, 1.0)])
    assert command.main(["other"]) == 0
    assert "the one" not in capsys.readouterr().out
    with pytest.raises(SystemExit, match="2"):
        command.main(["another"])
