"""Options of each extraction method, by the method's name."""

from collections.abc import Mapping

from modallab.core.options import OptionSpec, converted
from modallab.core.registry import member
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.options import ExtractionOptions
from modallab.extraction.single_mode.method import EXTRACTION_METHODS

OPTIONS: Mapping[str, type[ExtractionOptions]] = {
    **{name: method.options for name, method in EXTRACTION_METHODS.items()},
    **{name: method.options for name, method in GLOBAL_METHODS.items()},
}


def options_type(method: str) -> type[ExtractionOptions]:
    """Return the options dataclass of a method.

    Raises
    ------
    InvalidInputError
        If there is no such method.
    """
    return member(OPTIONS, method, "extraction method", field="method")


def method_options(method: str) -> Mapping[str, OptionSpec]:
    """Return the specifications of a method's options by name; raises as `options_type`."""
    return options_type(method).specs()


def options_for(method: str, options: ExtractionOptions | None) -> ExtractionOptions:
    """Return options as those of a method.

    Parameters
    ----------
    options
        Of the method, or common to it and others, such as `ExtractionOptions(damping=...)` of every method;
        None for the defaults.

    Raises
    ------
    InvalidInputError
        If there is no such method, or the options are those of another one.
    """
    expected = options_type(method)
    single_mode = method in EXTRACTION_METHODS
    reasons = {"leave_out": f"{method} needs the lines nearest resonance"} if single_mode else {}
    return converted(options, expected, method, reasons)
