"""The free beam of `tests.rigs` by hand: closed forms of the continuum, and its matrices in plain numpy."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from modallab.core.arrays import ComplexArray, FloatArray
from tests.rigs import BAR, STEEL

LENGTH, N_ELEMENTS = 1.5, 20
MASS = STEEL.density * BAR.area * LENGTH  # kg
RIGIDITY = STEEL.modulus * BAR.second_moment  # N m^2
MODES = np.arange(1, 7)  # beyond, cosh and sinh cancel in too many digits


def _wave_number(mode: int) -> float:
    return float(brentq(lambda z: np.cos(z) - 1 / np.cosh(z), mode * np.pi, (mode + 1) * np.pi)) / LENGTH


WAVE_NUMBERS = np.array([_wave_number(int(mode)) for mode in MODES])
FREQUENCIES = WAVE_NUMBERS**2 * np.sqrt(RIGIDITY * LENGTH / MASS) / (2 * np.pi)  # Hz


def place(node: int) -> float:
    """Where a node is, m."""
    return LENGTH * (node - 1) / N_ELEMENTS


def shapes(x: ArrayLike, *, curved: bool = False) -> FloatArray:
    """Shapes of all `MODES` at `x`, (n_modes, ...), or their curvature, of mean square 1 over the beam."""
    z = WAVE_NUMBERS[:, None] * LENGTH
    bx = np.multiply.outer(WAVE_NUMBERS, np.asarray(x, float).ravel())
    sign = -1.0 if curved else 1.0
    ratio = (np.cosh(z) - np.cos(z)) / (np.sinh(z) - np.sin(z))
    determinant = np.cosh(bx) + sign * np.cos(bx) - ratio * (np.sinh(bx) + sign * np.sin(bx))
    return np.asarray(determinant.reshape(len(MODES), *np.shape(x)))


def energy_shares(member: int, *, strain: bool) -> FloatArray:
    """A member's share of the strain or the kinetic energy of each mode, (n_modes,)."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    x = place(member) + (nodes + 1) / 2 * LENGTH / N_ELEMENTS
    return np.asarray(shapes(x, curved=strain) ** 2 @ weights / 2 / N_ELEMENTS)


def matrices(mass: dict[int, float], stiffness: dict[int, float]) -> tuple[FloatArray, FloatArray]:
    """Mass and stiffness, (42, 42), with factors for members by number: Y and RZ of each node in turn."""
    h = LENGTH / N_ELEMENTS
    part_m = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    )
    part_k = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    )
    m, k = np.zeros((42, 42)), np.zeros((42, 42))
    for member in range(1, N_ELEMENTS + 1):
        member_dofs = slice(2 * member - 2, 2 * member + 2)
        m[member_dofs, member_dofs] += mass.get(member, 1.0) * STEEL.density * BAR.area * h / 420 * part_m
        k[member_dofs, member_dofs] += stiffness.get(member, 1.0) * RIGIDITY / h**3 * part_k
    return m, k


def inertance(m: FloatArray, k: FloatArray, freq: FloatArray, nodes: tuple[int, ...]) -> ComplexArray:
    """Inertance of nodes to a force at node 1, (n_freq, n_nodes), damped by D = 100 M + 0.005 K."""
    omega = 2 * np.pi * freq[:, None, None]
    dynamic = k + 1j * (100.0 * m + 0.005 * k) - omega**2 * m
    receptances = np.linalg.solve(dynamic, np.broadcast_to(np.eye(42)[:, :1], (len(freq), 42, 1)))
    return np.asarray(-(omega[:, 0] ** 2) * receptances[:, [2 * node - 2 for node in nodes], 0])
