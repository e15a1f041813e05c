"""All updating methods by name, with their options."""

from collections.abc import Mapping
from typing import Any

from modallab.core.options import OptionSpec
from modallab.core.registry import member
from modallab.updating.direct.method import DIRECT_METHODS, RegisteredDirectMethod
from modallab.updating.error_location.method import LOCATORS, ErrorLocationMethod
from modallab.updating.method import UPDATERS, UpdatingMethod
from modallab.updating.part import Part
from modallab.updating.responses.method import RESPONSE_UPDATERS

Method = UpdatingMethod[Any] | ErrorLocationMethod | RegisteredDirectMethod

METHODS: Mapping[str, Method] = {**UPDATERS, **RESPONSE_UPDATERS, **DIRECT_METHODS, **LOCATORS}


def method_called(name: str) -> Method:
    """Return a method by name.

    Raises
    ------
    InvalidInputError
        If there is no such method.
    """
    return member(METHODS, name, "updating method", field="method")


def method_options(method: str) -> Mapping[str, OptionSpec]:
    """Return the specifications of a method's options by name; raises as `method_called`."""
    return method_called(method).options.specs()


def parts_of(method: str) -> tuple[Part, ...]:
    """Return the parts that a method corrects by default; empty for a direct method."""
    registered = method_called(method)
    return () if isinstance(registered, RegisteredDirectMethod) else registered.parts
