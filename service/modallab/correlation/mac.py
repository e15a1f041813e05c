"""How alike two sets of modes are."""

from dataclasses import dataclass

import numpy as np
import scipy.optimize

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel

FLOOR = 0.3  # MAC of unlike shapes at ten DoFs or so hardly reaches it by chance


@dataclass(frozen=True, eq=False)
class Correlation:
    """Measured modes beside those of a model, at the DoFs both have."""

    mac: FloatArray  # (n_measured, n_model)
    pairs: tuple[tuple[int, int], ...]  # (measured, model), counted from 0
    frequency_differences: FloatArray  # (n_pairs,) measured minus model, Hz
    comac: FloatArray  # (n_common,)
    dofs: tuple[Dof, ...]  # the common ones, in their positive sense

    def __post_init__(self) -> None:
        object.__setattr__(self, "mac", frozen(self.mac, float, (None, None), name="mac"))
        shape = (len(self.pairs),)
        differences = frozen(self.frequency_differences, float, shape, name="frequency_differences")
        object.__setattr__(self, "frequency_differences", differences)
        object.__setattr__(self, "comac", frozen(self.comac, float, (len(self.dofs),), name="comac"))


def mac(first: ComplexArray | FloatArray, second: ComplexArray | FloatArray) -> FloatArray:
    """Return the modal assurance criterion of every pair of shapes, (n_first, n_second), 0 to 1.

    `|phi_x^H phi_a|^2 / (phi_x^H phi_x phi_a^H phi_a)` [3.19], with the conjugate transpose, so that a
    complex scale of either shape drops out. A shape of zeros is like nothing: 0.

    Parameters
    ----------
    first, second
        (n_dof, n_first) and (n_dof, n_second), any unit.

    References
    ----------
    Allemang, R. J. and Brown, D. L. (1982), Proc. 1st International Modal Analysis Conference, 110-116.
    """
    sizes = np.outer((np.abs(first) ** 2).sum(axis=0), (np.abs(second) ** 2).sum(axis=0))
    product = np.abs(first.conj().T @ second) ** 2
    values = np.divide(product, sizes, out=np.zeros(sizes.shape), where=sizes > 0)
    return np.asarray(np.minimum(values, 1.0))


def pair_modes(values: FloatArray, floor: float = FLOOR) -> tuple[tuple[int, int], ...]:
    """Return pairs (row, column) of a MAC matrix, each used once, in rising row.

    The assignment whose MAC values add up to most: where two rows want the same column, the pair of
    pairs decides and not the order of the rows. Pairs below `floor` are left out.
    """
    rows, columns = scipy.optimize.linear_sum_assignment(
        np.where(values >= floor, values, 0.0), maximize=True
    )
    return tuple(
        (int(r), int(c)) for r, c in zip(rows, columns, strict=True) if values[r, c] >= max(floor, 1e-12)
    )


def comac(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the coordinate modal assurance criterion of every DoF, (n_dof,), 0 to 1.

    `(sum |phi_x phi_a|)^2 / (sum |phi_x|^2 sum |phi_a|^2)` over paired modes, each first brought to its
    partner's scale. A DoF that moves in neither set agrees: 1.

    Parameters
    ----------
    first, second
        (n_dof, n_pairs), column beside column.

    References
    ----------
    Lieven, N. A. J. and Ewins, D. J. (1988), Proc. 6th International Modal Analysis Conference, 690-695.
    """
    power = (np.abs(first) ** 2).sum(axis=0)
    scale = (first.conj() * second).sum(axis=0) / np.where(power > 0, power, 1)
    scaled = np.abs(first * scale)
    other = np.abs(second)
    sizes = (scaled**2).sum(axis=1) * (other**2).sum(axis=1)
    still = ((scaled**2).sum(axis=1) == 0) & ((other**2).sum(axis=1) == 0)
    product = (scaled * other).sum(axis=1) ** 2
    values = np.divide(product, sizes, out=still.astype(float), where=sizes > 0)
    return np.asarray(np.minimum(values, 1.0))


def compare(model: ModalModel, measured: ModalModel, *, floor: float = FLOOR) -> Correlation:
    """Return how measured modes correlate with those of a model.

    Only the DoFs that both have count; a DoF with sign -1 holds the negative component, and is turned.

    Raises
    ------
    InvalidInputError
        If the two have no DoF in common, or one has no modes.
    """
    dofs, (ours, theirs) = _common(measured, model)
    values = mac(ours, theirs)
    pairs = pair_modes(values, floor)
    rows, columns = [r for r, _ in pairs], [c for _, c in pairs]
    return Correlation(
        mac=values,
        pairs=pairs,
        frequency_differences=measured.frequencies[rows] - model.frequencies[columns],
        comac=comac(ours[:, rows], theirs[:, columns]),
        dofs=dofs,
    )


def _common(
    measured: ModalModel, model: ModalModel
) -> tuple[tuple[Dof, ...], tuple[ComplexArray, ComplexArray]]:
    """Return the common DoFs and the shapes there, (n_common, n_modes) each, in the positive sense."""
    sides = (measured, model)
    if not all(side.modes for side in sides):
        raise InvalidInputError("there are no modes to compare", field="modes", value=0, allowed="1 or more")
    # reversed, so that of a DoF given twice the first one counts
    rows = [{dof.point: i for i, dof in reversed(list(enumerate(side.dofs)))} for side in sides]
    dofs = tuple(sorted(rows[0].keys() & rows[1].keys()))
    if not dofs:
        raise InvalidInputError(
            "the two sets of modes share no degree of freedom",
            field="dofs",
            value=", ".join(str(dof) for dof in measured.dofs[:5]),
            allowed=", ".join(str(dof) for dof in model.dofs[:5]),
        )
    shapes = []
    for side, row in zip(sides, rows, strict=True):
        index = [row[dof] for dof in dofs]
        sign = np.array([side.dofs[i].sign for i in index])
        shapes.append(side.shapes[index] * sign[:, None])
    return dofs, (shapes[0], shapes[1])
