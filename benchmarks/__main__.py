"""Run every benchmark beside this file; exit with 1 if a ratio is over its limit."""

import importlib
import pkgutil
import sys
from pathlib import Path


def main() -> int:
    """Print name, ratio and limit of every benchmark; return 1 if a limit is broken."""
    folder = Path(__file__).parent
    broken = False
    for module in pkgutil.iter_modules([str(folder)]):
        benchmark = importlib.import_module(f"benchmarks.{module.name}")
        for name, ratio, limit in benchmark.run() if hasattr(benchmark, "run") else []:
            verdict = "" if ratio <= limit else "  OVER"
            broken |= bool(verdict)
            print(f"{name:<66} {ratio:8.3g}  limit {limit:<6.3g}{verdict}", flush=True)
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
