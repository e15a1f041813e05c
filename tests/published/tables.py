"""Published tables, read once."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray


def table(name: str) -> dict[str, Any]:
    """Return a table of this folder."""
    return tomllib.loads((Path(__file__).parent / f"{name}.toml").read_text(encoding="utf-8"))


def to_the_digit(found: FloatArray, printed: list[float], decimals: int) -> int:
    """Return how many numbers round to the printed ones."""
    rounded = np.round(np.asarray(found), decimals)
    return int((np.abs(rounded - np.array(printed)) < 0.1 * 10.0**-decimals).sum())
