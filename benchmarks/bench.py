"""What a module beside this file declares to take part in `python -m benchmarks`, and its command line."""

import argparse
import importlib
import pkgutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

Row = tuple[str, float, float]  # name, figure, limit
Rows = Sequence[Row]


@dataclass(frozen=True)
class Bench:
    """Figures with limits, `BENCH` of its module."""

    full: Callable[[], Rows]
    """Takes minutes; its figures are held against their limits."""
    short: Callable[[], Rows]
    """Takes seconds and the same path at a small size, where the limits mean nothing."""
    reads_proc: bool = False
    """Whether it reads the memory of a process in `/proc`, which Linux alone has."""

    @property
    def runs_here(self) -> bool:
        """Whether this system has what the bench reads."""
        return not self.reads_proc or Path("/proc/self/status").exists()


def benches() -> dict[str, Bench]:
    """Return the bench of every module that declares one, by the name of the module."""
    declared: dict[str, Bench] = {}
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        if module.ispkg or module.name == "__main__":
            continue
        bench = getattr(importlib.import_module(f"benchmarks.{module.name}"), "BENCH", None)
        if isinstance(bench, Bench):
            declared[module.name] = bench
    return declared


def parser(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of arguments that prints a module's docstring as it stands."""
    return argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )


def count(description: str | None, default: int, name: str = "tests") -> int:
    """Return the number that a command line states, how many of something, or its default."""
    arguments = parser(description)
    arguments.add_argument(name, type=int, nargs="?", default=default, help="default: %(default)s")
    return int(getattr(arguments.parse_args(), name))
