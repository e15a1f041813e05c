"""Write how fast a global extraction is beside that of another program.

    python -m venv /tmp/peer && /tmp/peer/bin/pip install sdypy-EMA
    export OPENBLAS_NUM_THREADS=1 PEER_PYTHON=/tmp/peer/bin/python
    python -m benchmarks.peer_report --write docs/speed.md

Runs the bench `peer_extraction`; without the other program there is nothing to compare with, and no page is
written. `--small` runs its short form.
"""

import os
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from benchmarks import peer_extraction
from benchmarks.bench import Row, parser

VERSION = "from importlib.metadata import version; print(version('sdypy-EMA'))"


def peer_version() -> str | None:
    """Return the version of the other program; None where it is not installed."""
    python = os.environ.get("PEER_PYTHON", sys.executable)
    asked = subprocess.run([python, "-I", "-c", VERSION], capture_output=True, text=True, check=False)
    return asked.stdout.strip() if asked.returncode == 0 else None


def processor() -> str:
    """Return the model of the processor, as far as this system tells."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{os.cpu_count()} cores{f' of {models[0]}' if models else ''}"


def page(rows: Sequence[Row], version: str, machine: str, load: float, date: str) -> str:
    """Return the page, Markdown."""
    table = "\n".join(f"| {name} | {figure:.2g} | {limit:g} |" for name, figure, limit in rows)
    return f"""# Speed against a peer

Terms and symbols: [glossary](glossary.md).

Written by `python -m benchmarks.peer_report --write docs/speed.md` on {date}:
{machine}, {load:.1f} processes at work before.
Processor times of one thread, medians of alternating rounds. What else runs changes their ratio little, as
long as it leaves the caches alone.

P is the processor time of `get_poles` of sdypy-EMA {version} at order {peer_extraction.ORDER},
with the same {peer_extraction.N_FRF} or {peer_extraction.FEW_FRFS} FRFs of {peer_extraction.N_LINES} lines.
It finds the poles of all orders. So does our chart, with their stability; a whole extraction adds the
selection of modes, their refinement, shapes and standard errors. Poly-reference LSCF has no counterpart
there: its time is over the same P. `make bench` holds all figures against their limits.

| figure | here | limit |
|---|---:|---:|
{table}

Modes are compared with the exact ones of the FRFs, in standard errors that the extraction states. Of the peer
count its poles nearest to the exact frequencies, which is kinder than its own selection.
"""


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("--write", type=Path, help="file of the page; left out: it is printed")
    arguments.add_argument("--small", action="store_true", help="a small size, in seconds")
    options = arguments.parse_args()
    if options.write is not None and os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        # A second thread that waits for the first counts as work.
        arguments.error("processor times are those of one thread: set OPENBLAS_NUM_THREADS=1")
    version, load = peer_version(), os.getloadavg()[0]
    rows = (peer_extraction.BENCH.short if options.small else peer_extraction.run)()
    text = page(rows, version or "(not installed)", processor(), load, f"{datetime.now(UTC):%Y-%m-%d}")
    if options.write is None or version is None:
        print(text)
    else:
        options.write.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
