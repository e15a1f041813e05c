"""Pages of the documentation, run as printed: their Python blocks in order, in a new interpreter."""

import os
import re
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from io import StringIO
from multiprocessing import get_context
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
LONGEST = 600.0  # s; a page takes seconds on an idle computer


def blocks(page: str, language: str = "python") -> list[str]:
    """Return the code blocks of a page in one language."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def run_page(page: str, folder: Path, check: Callable[[dict[str, Any]], None]) -> None:
    """Run a page's Python blocks in a folder and a new interpreter, then a check there.

    Parameters
    ----------
    check
        Function of a module, which gets the names that the blocks leave behind; `__printed__` is what they
        printed.
    """
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
        process.submit(_run, page, folder, check).result(LONGEST)


def _run(page: str, folder: Path, check: Callable[[dict[str, Any]], None]) -> None:
    os.environ["MPLBACKEND"] = "agg"
    os.chdir(folder)
    names: dict[str, Any] = {"__name__": "__main__"}
    try:
        with redirect_stdout(StringIO()) as printed:
            for number, block in enumerate(blocks(page), 1):
                exec(compile(block, f"{page}, block {number}", "exec"), names)
        check(names | {"__printed__": printed.getvalue()})
    finally:
        if "lab" in names:
            names["lab"].close()
