"""Heading of a report: what, by whom, when."""

from dataclasses import dataclass

from modallab.diagnosis.reporting.page import paragraph


@dataclass(frozen=True)
class ReportHeading:
    """What a report says of itself at its top; what is empty is left out."""

    title: str = ""
    """Title above the finding."""
    object: str = ""
    """Object that was tested."""
    author: str = ""
    """Who made the test or the report."""
    date: str = ""
    """Date of the test or the report."""


NO_HEADING = ReportHeading()


def heading_line(heading: ReportHeading) -> str:
    """Return object, author and date on one line, those that are given."""
    given = {"Object": heading.object, "Author": heading.author, "Date": heading.date}
    text = " \N{MIDDLE DOT} ".join(f"{name}: {value}" for name, value in given.items() if value)
    return paragraph(text, "soft") if text else ""
