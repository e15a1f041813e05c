"""Orthogonality of modes in the mass of a model reduced to the measured DoFs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.core.reply import Matrix, Vector
from modallab.fe.reduction import ReducedSystem


def orthogonality(first: ComplexArray, second: ComplexArray, mass: FloatArray) -> FloatArray:
    """Return |phi_x^H M phi_a| of every pair of shapes over their sizes in M, (n_first, n_second), 0 to 1.

    A MAC with the mass as its weight: between modes of one structure 1 and 0, not only nearly, if the mass
    is that of the structure and carries their motion in full. Of a set with itself it is called
    auto-orthogonality, of measured with computed modes cross-orthogonality. A shape without mass is
    like nothing: 0.

    Parameters
    ----------
    first, second
        (n_dof, n_first) and (n_dof, n_second), any unit.
    mass
        (n_dof, n_dof), kg, symmetric, not negative.

    References
    ----------
    Targoff, W. P. (1976), AIAA Journal 14(2), 164; in a reduced mass: Avitabile, P., O'Callahan, J. and
    Milani, J. (1988), Proc. 6th International Modal Analysis Conference.
    """
    sizes = [np.einsum("ir,ij,jr->r", x.conj(), mass, x).real for x in (first, second)]
    product = np.sqrt(np.maximum(np.outer(*sizes), 0.0))
    cross = np.abs(first.conj().T @ mass @ second)
    values = np.divide(cross, product, out=np.zeros(product.shape), where=product > 0)
    return np.asarray(np.minimum(values, 1.0))


def frequency_errors(reduced: ReducedSystem, computed: ComplexArray, frequencies: FloatArray) -> FloatArray:
    """Return the relative frequency errors of a reduced model, (n_modes,), by mode of the full model.

    Parameters
    ----------
    computed
        (n_master, n_modes) shapes of the full model at the masters.
    frequencies
        (n_modes,) Hz, of these modes, above zero.
    """
    reduced_frequencies, shapes = reduced.modes()
    # Modes may be missing or in another order: they are matched by shape.
    partner = orthogonality(computed, shapes.astype(complex), reduced.mass).argmax(axis=1)
    return np.asarray(reduced_frequencies[partner] / frequencies - 1)


@dataclass(frozen=True, eq=False)
class Orthogonality:
    """Orthogonality of measured and computed modes in a reduced mass, and the errors of the reduction."""

    reduction: str
    """Name of the reduction of the mass matrix."""
    parameters: Mapping[str, float]
    """Parameters of the reduction by name."""
    n_motions: int
    """Number of modes of the reduced model, rigid-body modes among them."""
    cross: Matrix
    """(n_measured, n_model) cross-orthogonality of measured and computed modes, 0 to 1."""
    auto: Matrix
    """(n_measured, n_measured) auto-orthogonality of the measured modes, 0 to 1."""
    frequency_errors: Vector = field(default_factory=lambda: np.zeros(0))
    """(n_model,) frequency of the reduced model over that of the full model, minus 1."""

    def __post_init__(self) -> None:
        for name, dimensions in (("cross", 2), ("auto", 2), ("frequency_errors", 1)):
            object.__setattr__(
                self, name, frozen(getattr(self, name), float, (None,) * dimensions, name=name)
            )

    @classmethod
    def of(
        cls, reduced: ReducedSystem, measured: ComplexArray, computed: ComplexArray, model: ModalModel
    ) -> Self:
        """Return the orthogonality of modes in the mass of a reduced model.

        Parameters
        ----------
        measured, computed
            (n_master, n_measured) and (n_master, n_model) shapes at the masters, in the positive sense.
        model
            The modes that `computed` is of.

        Raises
        ------
        InvalidInputError
            If shapes are known at other DoFs than the masters.
        """
        if len(measured) != len(reduced.masters):
            raise InvalidInputError(
                "orthogonality takes shapes at the masters of the reduction",
                field="masters",
                value=len(measured),
                allowed=len(reduced.masters),
            )
        return cls(
            reduction=reduced.reduction.kind,
            parameters=reduced.reduction.parameters,
            n_motions=len(reduced.modes()[0]),
            cross=orthogonality(measured, computed, reduced.mass),
            auto=orthogonality(measured, measured, reduced.mass),
            frequency_errors=frequency_errors(reduced, computed, model.frequencies),
        )
