"""What an excitation is: how its power stands to the analyser's record."""

from dataclasses import dataclass

from modallab.core.registry import Family


@dataclass(frozen=True)
class Excitation:
    """A kind of signal the source can play.

    `continuous` is the share of its power that does not repeat with the record, and so leaks.
    """

    summary: str
    continuous: float  # 0: periodic in the record, 1: a stationary random signal


EXCITATIONS: Family[Excitation] = Family("excitation", home="modallab.rig.excitations")
