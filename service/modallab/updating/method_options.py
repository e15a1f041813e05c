"""What each updating method may be told: for those who choose one."""

from collections.abc import Mapping

from modallab.core.errors import InvalidInputError
from modallab.core.options import OptionSpec
from modallab.fe.reduction import REDUCTIONS
from modallab.updating.direct.method import DIRECT_METHODS, EXPANSION, DirectOptions
from modallab.updating.error_location.method import LOCATORS
from modallab.updating.error_location.run import LocationOptions
from modallab.updating.method import UPDATERS, options_of
from modallab.updating.responses.method import RESPONSE_UPDATERS

DIRECT: Mapping[str, OptionSpec] = {
    "completion": OptionSpec(
        "shapes expanded to all DoFs of the model, or the model reduced to measured ones",
        choices=(EXPANSION, *REDUCTIONS),
        default=EXPANSION,
    ),
    "expansion": OptionSpec(
        "the reduction by which shapes are expanded",
        choices=tuple(REDUCTIONS),
        default=DirectOptions.expansion,
    ),
    "n_modes": OptionSpec("lowest measured modes that are used; all by default", "-", lower=1),
}


def method_options(method: str) -> Mapping[str, OptionSpec]:
    """Return the options of a method by name.

    Raises
    ------
    InvalidInputError
        If there is no such method.
    """
    if method in UPDATERS or method in RESPONSE_UPDATERS:
        return options_of(method)
    if method in LOCATORS:
        return LocationOptions.as_options()
    if method in DIRECT_METHODS:
        return DIRECT
    raise InvalidInputError(
        f"no updating method called {method!r}",
        field="method",
        value=method,
        allowed=", ".join(sorted([*UPDATERS, *RESPONSE_UPDATERS, *LOCATORS, *DIRECT_METHODS])),
    )
