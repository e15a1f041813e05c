"""What each method may be told: for those who choose one, and to refuse in time what it cannot do."""

from collections.abc import Mapping
from dataclasses import fields

from modallab.core.errors import InvalidInputError
from modallab.core.parameters import OptionSpec
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.options import MIN_LINES, MOST_ORDER, Damping, ExtractionOptions
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, TRAITS

COUNT = "1"  # unit of what is counted


SPECS: Mapping[str, OptionSpec] = {
    "lines": OptionSpec("lines around each resonance that a fit draws on", COUNT, lower=MIN_LINES),
    "leave_out": OptionSpec("of these, how many nearest resonance are not used", COUNT, lower=0),
    "damping": OptionSpec("law of a mode's damping", choices=tuple(Damping)),
    "max_order": OptionSpec("highest order of the stabilisation chart", COUNT, lower=2, upper=MOST_ORDER),
}


def method_options(method: str) -> Mapping[str, OptionSpec]:
    """Return the options of a method by name.

    Raises
    ------
    InvalidInputError
        If there is no such method.
    """
    if method in GLOBAL_METHODS:
        names: tuple[str, ...] = ("damping", "max_order")
    elif method in EXTRACTION_METHODS:
        names = ("lines", "leave_out", "damping") if TRAITS[method].leaves_out else ("lines", "damping")
    else:
        raise InvalidInputError(
            f"no extraction method called {method!r}",
            field="method",
            value=method,
            allowed=", ".join([*EXTRACTION_METHODS, *GLOBAL_METHODS]),
        )
    return {name: SPECS[name] for name in names}


def check_method_options(method: str, options: ExtractionOptions) -> None:
    """Refuse what a method cannot do.

    Raises
    ------
    InvalidInputError
        If there is no such method, or an option was given that it does not have.
    """
    able = method_options(method)
    for field in fields(options):
        given = getattr(options, field.name)
        if field.name not in able and given:  # no line left out is what such a method does anyway
            near = field.name == "leave_out" and method in EXTRACTION_METHODS
            why = f": {method} needs the lines nearest resonance" if near else ""
            raise InvalidInputError(
                f"{method} has no option {field.name!r}{why}",
                field=field.name,
                value=given,
                allowed=", ".join(able),
            )
