"""All updating methods by name, with their options."""

from collections.abc import Mapping

from modallab.core.errors import InvalidInputError
from modallab.core.options import OptionSpec
from modallab.updating.direct.method import DIRECT_METHODS, RegisteredDirectMethod
from modallab.updating.error_location.method import LOCATORS, ErrorLocationMethod
from modallab.updating.method import UPDATERS, ModalUpdatingMethod
from modallab.updating.part import Part
from modallab.updating.responses.method import RESPONSE_UPDATERS, ResponseUpdatingMethod

Method = ModalUpdatingMethod | ResponseUpdatingMethod | ErrorLocationMethod | RegisteredDirectMethod

METHODS: Mapping[str, Method] = {**UPDATERS, **RESPONSE_UPDATERS, **DIRECT_METHODS, **LOCATORS}


def method_called(name: str) -> Method:
    """Return a method by name.

    Raises
    ------
    InvalidInputError
        If there is no such method.
    """
    if name not in METHODS:
        raise InvalidInputError(
            f"no updating method called {name!r}",
            field="method",
            value=name,
            allowed=sorted(METHODS),
        )
    return METHODS[name]


def method_options(method: str) -> Mapping[str, OptionSpec]:
    """Return the specifications of a method's options by name; raises as `method_called`."""
    return method_called(method).options.specs()


def parts_of(method: str) -> tuple[Part, ...]:
    """Return the parts that a method corrects where none are named, none of a direct method."""
    registered = method_called(method)
    return () if isinstance(registered, RegisteredDirectMethod) else registered.parts
