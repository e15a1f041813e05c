"""The client alone, as `pip install modallab` makes it: size of the wheel and of all installed, import time.

    python -m benchmarks.client_alone [--imports 9]

Builds the wheel, installs it with its dependencies in a new environment, and asks there for help, the
version, and for a command that needs the numerics. Exits with 1 if a figure is over its limit or a command
fails.
"""

import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from benchmarks.bench import parser

ROOT = Path(__file__).parents[1]
WHEEL_LIMIT, INSTALLED_LIMIT = 3.0, 120.0  # MB
IMPORT_LIMIT = 0.5  # s, without plotting
TIMED = "import time; begin = time.perf_counter(); import {}; print(time.perf_counter() - begin)"
NOWHERE = "http://127.0.0.1:9"  # no lab: the command asks it, and says so
SLOWEST = 5  # imports that are named


def megabytes(files: Iterable[Path]) -> float:
    """Return the size of files, MB."""
    return sum(file.stat().st_size for file in files if file.is_file()) / 1e6


def said(python: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Return what a new interpreter of the environment says, without this folder on its path."""
    return subprocess.run([python, "-I", *arguments], capture_output=True, text=True, check=False)


def import_time(python: Path, module: str, rounds: int) -> float:
    """Return the least time of an import in new interpreters, s."""
    return min(float(said(python, "-c", TIMED.format(module)).stdout) for _ in range(rounds))


def slowest(python: Path, module: str) -> list[tuple[float, str]]:
    """Return the slowest packages of an import, ms with what each imports, and their names."""
    lines = said(python, "-X", "importtime", "-c", f"import {module}").stderr.splitlines()
    rows = [re.fullmatch(r"import time:\s+\d+ \|\s+(\d+) \| (\s*)([\w.]+)", line) for line in lines]
    found = [(int(row[1]) / 1e3, row[3]) for row in rows if row and row[3].partition(".")[0] != module]
    return sorted(((time, name) for time, name in found if "." not in name), reverse=True)[:SLOWEST]


def installed(folder: Path) -> tuple[Path, float, float]:
    """Return the interpreter of a new environment with the client alone, and MB of wheel and environment."""
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps"]
    subprocess.run([*pip, "--wheel-dir", str(folder), str(ROOT)], check=True)
    (wheel,) = folder.glob("*.whl")
    subprocess.run([sys.executable, "-m", "venv", str(folder / "env")], check=True)
    python = folder / "env" / "bin" / "python"
    before = megabytes((folder / "env").rglob("*"))  # pip and its like
    quiet = ["--quiet", "--disable-pip-version-check"]
    subprocess.run([python, "-m", "pip", "install", *quiet, str(wheel)], check=True)
    return python, megabytes([wheel]), megabytes((folder / "env").rglob("*")) - before


def commands(python: Path, folder: Path) -> list[str]:
    """Return what is wrong with commands of the client alone; nothing if they do what they should."""
    faults = [
        f"{name}: {run.stderr}"
        for name in ("--help", "--version")
        if (run := _modallab(python, name)).returncode
    ]
    (folder / "empty.uff").touch()
    away = _modallab(python, "extract", str(folder / "empty.uff"), "--server", NOWHERE)
    print("modallab extract --server:", away.stderr.strip())
    if away.returncode == 0 or NOWHERE not in away.stderr:
        faults.append(f"--server: {away.stderr}")
    extra = _modallab(python, "openapi")
    print(extra.stderr.strip())
    if extra.returncode != 2 or extra.stderr.count("\n") != 1 or "modallab[service]" not in extra.stderr:
        faults.append(f"openapi: {extra.stderr}")
    return faults


def _modallab(python: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    return said(python, "-m", "modallab", *arguments)


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument(
        "--imports", type=int, default=9, help="new interpreters, of which the best counts"
    )
    rounds = arguments.parse_args().imports
    with tempfile.TemporaryDirectory() as folder:
        python, wheel, environment = installed(Path(folder))
        seconds = import_time(python, "modallab_client", rounds)
        faults = commands(python, Path(folder))
        for time, name in slowest(python, "modallab_client"):
            print(f"  import of {name} with what it needs: {time:.0f} ms")
    rows = [
        ("wheel, MB", wheel, WHEEL_LIMIT),
        ("client alone installed, MB", environment, INSTALLED_LIMIT),
        (f"import modallab_client, best of {rounds}, s", seconds, IMPORT_LIMIT),
    ]
    for name, figure, limit in rows:
        print(f"{name:45} {figure:8.3f}  at most {limit:g}{'  OVER' if figure > limit else ''}")
    print(*faults, sep="\n", end="\n" if faults else "")
    sys.exit(1 if faults or any(figure > limit for _, figure, limit in rows) else 0)


if __name__ == "__main__":
    main()
