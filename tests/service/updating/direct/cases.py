"""Small models whose measured modes are known at every degree of freedom."""

from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import exact_modes
from modallab.updating.direct.completion import complete
from modallab.updating.direct.method import (
    DIRECT_METHODS,
    Correction,
    DirectOptions,
    DirectProblem,
    ErrorLocation,
)

BEAM = STRUCTURES["cantilever"]()
SYSTEM = assemble(BEAM)
STIFFER = change(BEAM, [MemberChange((11, 12), MemberProperty.MODULUS, factor=2.0)])
HEAVIER = change(BEAM, [MemberChange((5, 6), MemberProperty.DENSITY, factor=1.5)])
BOTH = change(STIFFER, [MemberChange((5, 6), MemberProperty.DENSITY, factor=1.5)])


def measured(structure: Structure, count: int) -> ModalModel:
    """Return exact modes at every degree of freedom."""
    return exact_modes(assemble(structure), count)


def problem(structure: Structure, count: int, model: Structure = BEAM) -> DirectProblem:
    """Return what a method is given of a model, and of modes of another structure."""
    return complete(assemble(model), measured(structure, count), DirectOptions()).problem(count)


def wrong_rows(structure: Structure, matrix: str, model: Structure = BEAM) -> set[int]:
    """Return the rows in which a matrix of the model is wrong."""
    error = abs(getattr(assemble(structure), matrix) - getattr(assemble(model), matrix)).toarray()
    return set(error.any(axis=1).nonzero()[0].tolist())


def corrected(method: str, given: DirectProblem) -> Correction:
    """Return what a method makes of a problem that must correct matrices."""
    found = DIRECT_METHODS[method](given)
    assert isinstance(found, Correction)
    return found


def located(method: str, given: DirectProblem) -> ErrorLocation:
    """Return what a method makes of a problem that must locate errors."""
    found = DIRECT_METHODS[method](given)
    assert isinstance(found, ErrorLocation)
    return found
