"""The client alone is small: its wheel, what it brings with it, and what an import of it loads."""

import re
import subprocess
import sys
import tomllib
import zlib
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
WHEEL, INSTALLED = 3e6, 120e6  # bytes, promised in the changelog
PLOTTING_AND_TABLES = ["matplotlib", "pandas", "xarray", "tqdm", "IPython", "scipy", "pydantic"]


def test_the_wheel_with_the_page_in_it_is_at_most_3_mb() -> None:
    packages = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    files = [path for package in packages for path in (ROOT / package).rglob("*") if path.is_file()]
    packed = sum(len(zlib.compress(path.read_bytes())) for path in files if "__pycache__" not in path.parts)
    assert any(path.name == "index.html" for path in files)
    assert packed < WHEEL


def test_the_client_alone_brings_at_most_120_mb() -> None:
    """Sizes of what is installed here; `benchmarks.client_alone` installs it anew."""
    waiting, seen, total = list(PROJECT["project"]["dependencies"]), set[str](), 0
    while waiting:
        requirement, _, condition = waiting.pop().partition(";")
        name = re.split(r"[^\w.-]", requirement.strip())[0].lower()
        if name in seen or "extra ==" in condition:
            continue
        seen.add(name)
        try:
            found = distribution(name)
        except PackageNotFoundError:  # for another system or an older Python
            assert condition, name
            continue
        files = [Path(str(file.locate())) for file in found.files or []]
        total += sum(file.stat().st_size for file in files if file.is_file())
        waiting += found.requires or []
    assert {"numpy", "httpx", "click"} < seen
    assert total < INSTALLED


def test_an_import_of_the_client_loads_no_plotting_and_no_tables() -> None:
    """They may be installed, and take seconds."""
    code = "import sys, modallab_client; print(*{name.partition('.')[0] for name in sys.modules})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not set(PLOTTING_AND_TABLES) & set(run.stdout.split())
