"""Complexity of mode shapes: phase differences between the points of a mode.

With proportional damping, structural or viscous, all points of a mode move in phase or in antiphase, and its
shape is real but for a common factor. Local damping, close modes and measurement errors make phases differ.
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray


@dataclass(frozen=True)
class ShapeComplexity:
    """Complexity of one mode shape."""

    mpc: float
    """Modal phase collinearity, 0 to 1; 1: all points move in phase or in antiphase."""
    mean_phase: float
    """rad, -pi/2 to pi/2, phase of the line nearest to the shape."""
    mean_phase_deviation: float
    """rad, mean deviation of the phases from that line."""


def shape_complexities(shapes: ComplexArray) -> tuple[ShapeComplexity, ...]:
    """Return the complexity of each shape.

    Parameters
    ----------
    shapes
        (n_dof, n_modes), any unit.
    """
    columns = (phase_collinearity(shapes), mean_phase(shapes), mean_phase_deviation(shapes))
    return tuple(ShapeComplexity(*row) for row in np.stack(columns, axis=1).tolist())


def phase_collinearity(shapes: ComplexArray) -> FloatArray:
    """Return the modal phase collinearity of each shape, (n_modes,): 1 for a line in the complex plane.

    `|phi^T phi|^2 / (phi^H phi)^2`, which equals `((s_xx - s_yy)^2 + 4 s_xy^2)/(s_xx + s_yy)^2` of the real
    and imaginary parts. A complex factor drops out; 0 is a wave that travels, as on a turning disc. A
    shape of zeros is no line: 0.

    Parameters
    ----------
    shapes
        (n_dof, n_modes), any unit.

    References
    ----------
    Pappa, R. S., Elliott, K. B. and Schenk, A. (1993), J. Guidance, Control and Dynamics 16(5), 852-858.
    """
    shapes = _scaled(shapes)
    size = (np.abs(shapes) ** 2).sum(axis=0)
    line = np.abs((shapes**2).sum(axis=0))
    return np.asarray(np.minimum(line / np.where(size > 0, size, 1.0), 1.0) ** 2)


def mean_phase(shapes: ComplexArray) -> FloatArray:
    """Return the angle of the line that each shape lies nearest to, (n_modes,) rad, -pi/2 to pi/2.

    `arg(phi^T phi)/2`: the axis of least squared distances across it, so that large components count most
    and opposite ones alike.

    Parameters
    ----------
    shapes
        (n_dof, n_modes), any unit.
    """
    return np.asarray(np.angle((_scaled(shapes) ** 2).sum(axis=0)) / 2)


def mean_phase_deviation(shapes: ComplexArray) -> FloatArray:
    """Return the mean phase deviation of each shape, (n_modes,) rad, 0 to pi/2.

    The mean over the points of the angle between each component and the line of `mean_phase`, weighted by
    the component's size, so that points near a node, whose phase is noise, hardly count.

    Parameters
    ----------
    shapes
        (n_dof, n_modes), any unit.

    References
    ----------
    Reynders, E., Houbrechts, J. and De Roeck, G. (2012), Mech. Syst. Signal Process. 29, 228-250.
    """
    rotated = _scaled(shapes) * np.exp(-1j * mean_phase(shapes))
    size = np.abs(rotated)
    angle = np.arctan2(np.abs(rotated.imag), np.abs(rotated.real))
    total = size.sum(axis=0)
    return np.asarray((size * angle).sum(axis=0) / np.where(total > 0, total, 1.0))


def _scaled(shapes: ComplexArray) -> ComplexArray:
    """Return the shapes with their largest component of size 1, so that squares stay numbers."""
    largest = np.abs(shapes).max(axis=0, initial=0.0)
    return np.asarray(shapes / np.where(largest > 0, largest, 1.0), np.complex128)
