"""Pages of the documentation, run as printed: their Python blocks in order, in a new interpreter."""

import os
import re
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from io import StringIO
from multiprocessing import get_context
from pathlib import Path
from traceback import format_exc
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
Check = Callable[[dict[str, Any]], None]
LONGEST = 600.0  # s; a page takes seconds on an idle computer


def blocks(page: str, language: str = "python") -> list[str]:
    """Return the code blocks of a page in one language."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def run_page(page: str, folder: Path, check: Check) -> None:
    """Run a page's Python blocks in a folder and a new interpreter, then a check there.

    Parameters
    ----------
    check
        Function of a module, which gets the names that the blocks leave behind; `__printed__` is what they
        printed.
    """
    (failure,) = outcomes(page, folder, [check]).values()
    assert not failure, failure


def outcomes(page: str, folder: Path, checks: Sequence[Check]) -> dict[str, str]:
    """Return what each check of a page found wrong, by its name; "" where it found nothing."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        return process.submit(_run, page, folder, checks).result(LONGEST)


def _run(page: str, folder: Path, checks: Sequence[Check]) -> dict[str, str]:
    os.environ["MPLBACKEND"] = "agg"
    os.chdir(folder)
    names: dict[str, Any] = {"__name__": "__main__"}
    try:
        with redirect_stdout(StringIO()) as printed:
            for number, block in enumerate(blocks(page), 1):
                exec(compile(block, f"{page}, block {number}", "exec"), names)
        left = names | {"__printed__": printed.getvalue()}
        return {check.__name__: _failure(check, left) for check in checks}
    finally:
        if "lab" in names:
            names["lab"].close()


def _failure(check: Check, names: dict[str, Any]) -> str:
    try:
        check(names)
    except Exception:
        return format_exc()
    return ""
