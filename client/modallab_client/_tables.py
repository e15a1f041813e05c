"""Small tables, as text for a terminal and as HTML for a notebook."""

from collections.abc import Sequence
from html import escape

Row = Sequence[str]
Table = tuple[Row, Sequence[Row]]


def text(head: Row, rows: Sequence[Row], *, words: bool = False) -> str:
    """Return a table with right-aligned columns, two spaces between them.

    Parameters
    ----------
    words
        The last column has words, aligned left.
    """
    lines = [head, *rows]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    if words:
        widths[-1] = 0
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def html(head: Row, rows: Sequence[Row], *, caption: str) -> str:
    """Return a table as HTML, every cell escaped; no head row where `head` is empty."""
    top = f"<thead><tr>{_cells(head, 'th')}</tr></thead>" if head else ""
    body = "".join(f"<tr>{_cells(row, 'td')}</tr>" for row in rows)
    return f"<table><caption>{escape(caption)}</caption>{top}<tbody>{body}</tbody></table>"


def _cells(row: Row, tag: str) -> str:
    return "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row)
