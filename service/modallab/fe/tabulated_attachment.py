"""Attachment whose dynamic stiffness is a curve over frequency."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.frequency_table import FrequencyTable
from modallab.fe.attachment import Attachment


@dataclass(frozen=True, eq=False)
class TabulatedAttachment(Attachment):
    """Dynamic stiffness between one motion and the ground that a table gives.

    No matrix of mass, stiffness and damping has it: solutions for modes leave it out, and receptances take
    it in by the Woodbury identity.
    """

    table: FrequencyTable | None = None
    """N/m, or N m/rad of a rotation; always given."""
    scale: float = 1.0
    """Factor of the table."""

    @property
    def is_constant(self) -> bool:
        """Whether constant matrices describe it."""
        return False

    @property
    def key(self) -> tuple[object, ...]:
        """All values, bit by bit: equal for equal attachments."""
        assert self.table is not None
        return 0, (self.columns.shape, self.columns.tobytes()), self.table.rows, self.scale

    def _stiffness(self, omega: FloatArray) -> ComplexArray:
        assert self.table is not None
        z = self.scale * self.table.at(omega / (2 * np.pi))[:, None, None]
        z.flags.writeable = False
        return np.asarray(z)
