"""Family of catalogue structures: functions without parameters that return a structure."""

from collections.abc import Callable

from modallab.core.registry import Family
from modallab.fe.structure import Structure

STRUCTURES: Family[Callable[[], Structure]] = Family("structure", home="modallab.fe.catalogue")
