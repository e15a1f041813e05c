"""Run every bench beside this file; exit with 1 if a figure is over its limit or a bench fails.

python -m benchmarks                  # in full, with limits
python -m benchmarks --short          # each once at a small size: does it run?
python -m benchmarks lscf memory      # these alone
"""

import argparse
import math
import sys
import time
import traceback
from collections.abc import Sequence

from benchmarks.bench import Bench, Row, benches


def fault(row: Row, short: bool) -> str:
    """Return what is wrong with a figure; the short form asks only that it is a number."""
    _, figure, limit = row
    if not math.isfinite(figure):
        return "NOT FINITE"
    return "" if short or figure <= limit else "OVER"


def run(name: str, bench: Bench, short: bool) -> list[str]:
    """Print the figures of a bench, and return its faults."""
    if not bench.runs_here:
        print(f"{name}: skipped, this system has no /proc", flush=True)
        return []
    faults = []
    start = time.monotonic()
    try:
        rows = (bench.short if short else bench.full)()
    except Exception as error:  # the others run all the same
        traceback.print_exc()
        print(f"{name}: FAILED, {type(error).__name__}", flush=True)
        return [f"{name}: {type(error).__name__}: {error}"]
    for row in rows:
        label, figure, limit = row
        verdict = fault(row, short)
        limit_text = "" if short else f"  limit {limit:<6.3g}"
        print(f"{label:<86} {figure:8.3g}{limit_text}  {verdict}".rstrip(), flush=True)
        if verdict:
            faults.append(f"{label}: {figure:.3g}, {verdict}, limit {limit:.3g}")
    print(f"  {name}: {time.monotonic() - start:.1f} s", flush=True)
    return faults


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benches, list their faults, and return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    declared = benches()
    parser.add_argument("names", nargs="*", metavar="name", help=f"of {', '.join(declared)}")
    parser.add_argument("--short", action="store_true", help="a small size of each, without limits")
    options = parser.parse_args(arguments)
    unknown = sorted(set(options.names) - declared.keys())
    if unknown:
        parser.error(f"no bench {', '.join(unknown)}; there are {', '.join(declared)}")
    faults = [line for name in options.names or declared for line in run(name, declared[name], options.short)]
    print(f"{len(faults)} faults", *faults, sep="\n  ")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
