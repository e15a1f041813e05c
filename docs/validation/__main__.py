"""Write the validation report: `python -m docs.validation`."""

from pathlib import Path

from docs.validation import beam, damped, frames, stingers
from docs.validation.comparison import Comparison

TARGET = Path(__file__).parents[1] / "validation.md"
# Tables of the thesis that have no counterpart here, and why.
LEFT_OUT = {
    "Tables 2.2 to 2.4, 3.3, 3.5 to 3.7, 4.2 and 6.6 to 6.10": "their numbers are missing from the copy "
    "that was available. `tests/published` holds their cases to what the text says of them",
    "Table 3.2": "singular values of two sensitivity matrices; the scale of their rows is not stated",
}


def comparisons() -> list[Comparison]:
    """Return all tables in the order of the thesis."""
    return [*frames.comparisons(), *beam.comparisons(), *damped.comparisons(), *stingers.comparisons()]


def report(tables: list[Comparison]) -> str:
    """Return the report, Markdown."""
    numbers, beyond = sum(one.n_numbers for one in tables), sum(one.n_beyond for one in tables)
    rows = [
        f"| [{one.number}](#{_anchor(one)}) | {one.title} | {one.n_numbers} | {one.n_beyond} |"
        for one in tables
    ]
    left_out = "\n".join(f"- {name}: {reason}." for name, reason in LEFT_OUT.items())
    summary = "\n".join(["| | | numbers | beyond the printed digit |", "|---|---|---:|---:|", *rows])
    head = f"""<!-- Written by `make validation` from docs/validation: edit that. -->

# Validation report

Terms and symbols: [glossary](glossary.md).

Tables of a PhD thesis of 1992 on model updating beside the same numbers from this code. Of {numbers} numbers,
{numbers - beyond} agree to the printed digit. The other {beyond} (bold) differ by more than half of that
digit; the reason stands in the row or under the table. Numbers of modallab have one digit more than the
printed ones.
The printed numbers are in `tests/published`; `make validation` writes this page.

{summary}

Not compared:

{left_out}
"""
    return "\n\n".join([head.rstrip(), *(one.markdown() for one in tables)]) + "\n"


def _anchor(one: Comparison) -> str:
    text = f"{one.number}: {one.title}".lower()
    kept = "".join(letter for letter in text if letter.isalnum() or letter in " -_")
    return kept.replace(" ", "-")


if __name__ == "__main__":
    TARGET.write_text(report(comparisons()), encoding="utf-8")
