"""Progress of a job on the screen: a bar by tqdm where it is installed, else lines of text."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class ProgressBar:
    """Shows how far a job is, as a bar, in a notebook or a terminal; without tqdm as a line a tenth."""

    def __init__(self) -> None:
        self._bar = _bar()
        self._tenth = -1

    def __call__(self, fraction: float, message: str) -> None:
        if self._bar is None:
            if int(10 * fraction) > self._tenth:
                self._tenth = int(10 * fraction)
                print(f"{fraction:4.0%}  {message}".rstrip(), file=sys.stderr)  # noqa: T201
            return
        self._bar.set_postfix_str(message, refresh=False)
        self._bar.n = round(100 * fraction)
        self._bar.refresh()

    def close(self) -> None:
        """Leave the bar as it stands."""
        if self._bar is not None:
            self._bar.close()


@contextmanager
def progress_bar(*, wanted: bool) -> Iterator[ProgressBar | None]:
    """Yield a bar that is closed with the context; None where none is wanted."""
    if not wanted:
        yield None
        return
    bar = ProgressBar()
    try:
        yield bar
    finally:
        bar.close()


def _bar() -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm(total=100, bar_format="{percentage:3.0f}%|{bar:30}| {elapsed} {postfix}", leave=True)
