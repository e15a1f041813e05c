"""Options of each extraction method, by the method's name."""

from collections.abc import Mapping
from dataclasses import fields

from modallab.core.errors import InvalidInputError
from modallab.core.options import OptionSpec
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
    if method not in OPTIONS:
        raise InvalidInputError(
            f"no extraction method called {method!r}",
            field="method",
            value=method,
            allowed=", ".join(OPTIONS),
        )
    return OPTIONS[method]


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
    if options is None:
        return expected()
    if type(options) is expected:
        return options
    allowed = expected.specs()
    for f in fields(options):
        value = getattr(options, f.name)
        if f.name not in allowed and value:  # leaving out no line is what every method can do
            near = f.name == "leave_out" and method in EXTRACTION_METHODS
            why = f": {method} needs the lines nearest resonance" if near else ""
            raise InvalidInputError(
                f"{method} has no option {f.name!r}{why}",
                field=f.name,
                value=value,
                allowed=", ".join(allowed),
            )
    return expected(**{f.name: getattr(options, f.name) for f in fields(options) if f.name in allowed})
