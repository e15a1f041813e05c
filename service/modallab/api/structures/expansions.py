"""Wire types of measured modes at all DoFs of a structure."""

from modallab.api.deps import Id
from modallab.api.reductions import Reduced
from modallab.api.wire import Wire


class ExpansionIn(Wire):
    """Measured modes, and how all DoFs follow the measured ones."""

    modal_model_id: Id
    """id of the measured modes"""
    reduction: Reduced = "serep"
    """reduction whose transformation expands the shapes, with its parameters or by name alone"""
