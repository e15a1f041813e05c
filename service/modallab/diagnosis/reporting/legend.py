"""What the marks of a report's drawings mean."""

from collections.abc import Sequence
from html import escape

LEGEND = (
    ("measured", "measured"),
    ("noise", "± 2 random errors"),
    ("before", "predicted as given"),
    ("after", "with what was added"),
)


def legend(added: bool) -> str:
    """Return what the curves' colours mean; where nothing was added, before and after are one curve."""
    return keys(LEGEND if added else LEGEND[:3])


def keys(pairs: Sequence[tuple[str, str]]) -> str:
    """Return the legend of a drawing: style and text of each mark."""
    return " ".join(
        f'<span class="entry"><span class="key {style}"></span>{escape(text)}</span>' for style, text in pairs
    )
