"""What a catalogue structure is: a function of nothing that returns it."""

from collections.abc import Callable

from modallab.core.registry import Family
from modallab.fe.structure import Structure

STRUCTURES: Family[Callable[[], Structure]] = Family("structure", home="modallab.fe.catalogue")
