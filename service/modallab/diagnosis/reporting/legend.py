"""Legends of the drawings of a report."""

from collections.abc import Sequence
from html import escape

LEGEND = (
    ("measured", "measured"),
    ("noise", "± 2 random errors"),
    ("before", "initial prediction"),
    ("after", "with the added effects"),
)


def legend(added: bool) -> str:
    """Return the legend of the curves; without added effects there is one predicted curve."""
    return keys(LEGEND if added else LEGEND[:3])


def keys(pairs: Sequence[tuple[str, str]]) -> str:
    """Return a legend from the style and text of each mark."""
    return " ".join(
        f'<span class="entry"><span class="key {style}"></span>{escape(text)}</span>' for style, text in pairs
    )
