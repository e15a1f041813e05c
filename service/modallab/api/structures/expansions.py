"""Wire types of measured modes at all DoFs of a structure."""

from typing import Self

from modallab.api.deps import Id
from modallab.api.modal_models.found import ModalModelOut
from modallab.api.reductions import Reduced
from modallab.api.wire import Wire
from modallab.fe.expansion import Expansion
from modallab.store.base import Entry


class ExpansionIn(Wire):
    """Measured modes, and how all DoFs follow the measured ones."""

    modal_model_id: Id
    """id of the measured modes"""
    reduction: Reduced = "serep"
    """reduction whose transformation expands the shapes, with its parameters or by name alone"""


class ExpandedOut(ModalModelOut):
    """A modal model at all DoFs; by mode, how far the structure goes along with what was measured.

    `fit_residuals`: share of the measured shape that the expanded one does not have. `rayleigh_frequencies`:
    Hz, at which strain and kinetic energy of the structure balance in the expanded shape.
    """

    fit_residuals: list[float]
    """1, share of each measured shape that the expanded shape misses"""
    rayleigh_frequencies: list[float]
    """Hz, Rayleigh quotient of the structure with each expanded shape"""

    @classmethod
    def of_expansion(cls, found: Expansion, entry: Entry) -> Self:
        """Return what the contract shows of an expansion."""
        return cls(
            **ModalModelOut.of(found.model, entry).model_dump(),
            fit_residuals=found.residual.tolist(),
            rayleigh_frequencies=found.rayleigh.tolist(),
        )
