"""Code blocks of all pages: whole scripts from top to bottom, each run by a test."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.pages import DOCS

ROOT = DOCS.parent
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
CODE = re.compile(r"^```(python|bash)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
RUFF = Path(sys.executable).parent / "ruff"


def scripts(language: str) -> dict[Path, str]:
    """Return each page's code in a language, blocks one after the other."""
    found = {}
    for page in PAGES:
        code = CODE.findall(page.read_text(encoding="utf-8"))
        found[page] = "".join(block for kind, block in code if kind == language)
    return {page: code for page, code in found.items() if code}


@pytest.mark.parametrize("page", scripts("python"), ids=lambda page: page.name)
def test_python_of_a_page_needs_no_name_that_the_page_does_not_give(page: Path) -> None:
    command = [
        str(RUFF),
        "check",
        "--isolated",
        "--select",
        "F821,F822,E9",
        "--stdin-filename",
        "page.py",
        "-",
    ]
    done = subprocess.run(command, input=scripts("python")[page], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize("page", scripts("bash"), ids=lambda page: page.name)
def test_bash_of_a_page_is_bash(page: Path) -> None:
    command, script = ["bash", "-n"], scripts("bash")[page]
    done = subprocess.run(command, input=script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_each_page_with_code_has_a_test_that_runs_it() -> None:
    tests = "".join(
        path.read_text(encoding="utf-8")
        for folder in ("docs", "end_to_end")
        for path in (ROOT / "tests" / folder).glob("test_*.py")
        if path != Path(__file__)
    )
    for page in {*scripts("python"), *scripts("bash")}:
        assert f'"{page.name}"' in tests, f"no test runs the code of {page.name}"
