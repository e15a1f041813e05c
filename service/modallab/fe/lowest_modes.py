"""Lowest modes of a large system by shift-invert Lanczos iteration, counted by Sylvester's law of inertia."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, SuperLU, eigsh, splu

from modallab.core.arrays import FloatArray
from modallab.core.errors import StructureError
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.truncation import ModalTruncation

# Of an eigenvalue of the inverse that is iterated for; of a very thin plate rounding leaves less.


@dataclass(frozen=True, eq=False)
class LowestModes:
    """All modes below some frequency, rigid-body modes first, and the truncated remainder."""

    squares: FloatArray  # (m,) rad^2/s^2, rising
    shapes: FloatArray  # (n, m) mass-normalised
    highest: float  # rad^2/s^2, below which there is no other
    remainder: ModalTruncation


def factorised(matrix: csc_array) -> SuperLU:
    """Return L U of a symmetric matrix, by pivots on its diagonal.

    Pivots off the diagonal would undo the fill-reducing ordering, at four times the work for a plate;
    a definite matrix needs none.

    Raises
    ------
    MemoryError
        If the factors do not fit into the memory that the process may have.
    """
    try:
        return splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError as error:
        if "MALLOC" in str(error):  # SuperLU's way to say that there is no more memory
            raise MemoryError(str(error)) from error
        raise


def count_below(mass: csc_array, stiffness: csc_array, square: float) -> int | None:
    """Return the number of eigenvalues below `square`, rad^2/s^2; None if rounding makes it uncertain.

    It equals the number of negative pivots of K - square M.

    Sylvester's law of inertia; Parlett, The Symmetric Eigenvalue Problem (1980), chapter 3.
    """
    for _ in range(EIGENSOLUTION.inertia_attempts):
        try:
            factor = factorised(csc_array(stiffness - square * mass))
        except RuntimeError:  # a pivot of exactly zero
            square *= 1 + EIGENSOLUTION.relative_gap
            continue
        if np.array_equal(factor.perm_r, factor.perm_c):
            return int((factor.U.diagonal() < 0).sum())
        square *= 1 + EIGENSOLUTION.relative_gap
    return None


def lowest_below(
    mass: csc_array,
    stiffness: csc_array,
    bodies: FloatArray,
    highest: float,
    near: FloatArray | None = None,
) -> LowestModes:
    """Return all modes below `highest`, rad^2/s^2.

    Parameters
    ----------
    bodies
        (n, n_rigid) mass-normalised rigid-body modes.
    near
        (n, k) modes of a similar system as starting vectors.
    """
    # Factorising K + s M instead of K keeps a free structure regular; s near the first elastic
    # eigenvalues keeps the low modes well separated.
    search = _ModeSearch(mass, stiffness, bodies, max(EIGENSOLUTION.band_shift * highest, 1.0))
    n_below = count_below(mass, stiffness, highest)
    if n_below is None:
        squares, shapes = search.pairs(EIGENSOLUTION.uncounted_modes, near)
        while squares.max() <= highest and len(squares) < search.elastic:
            squares, shapes = search.more(squares, shapes, len(squares))
        return search.band(squares, shapes, highest, 0)
    count = n_below - bodies.shape[1]
    if count < 1:
        return search.band(np.zeros(0), np.zeros((len(bodies), 0)), highest, 0)
    return search.band(*search.pairs(count, near), highest, count)


def lowest_first(mass: csc_array, stiffness: csc_array, bodies: FloatArray, count: int) -> LowestModes:
    """Return the rigid-body modes and the first elastic ones: `count`, all if there are no more.

    A few more where the last of them are close to the next.
    """
    search = _scaled_search(mass, stiffness, bodies)
    squares, shapes = search.pairs(min(count + 1, search.elastic), None)
    while True:
        squares, shapes = _sorted(squares, shapes)
        ends = np.flatnonzero(np.diff(squares) > EIGENSOLUTION.relative_gap * squares[1:])
        ends = ends[ends >= count - 1]
        if ends.size:
            highest = float(squares[ends[0] : ends[0] + 2].mean())
            n_below = count_below(mass, stiffness, highest) or 0
            return search.band(squares, shapes, highest, n_below - bodies.shape[1])
        if len(squares) >= search.elastic:
            return search.band(squares, shapes, np.inf, len(squares))
        squares, shapes = search.more(squares, shapes, 2)


def _scaled_search(mass: csc_array, stiffness: csc_array, bodies: FloatArray) -> "_ModeSearch":
    """Return a search with a shift no larger than the first elastic eigenvalues."""
    largest = float((abs(stiffness).sum(axis=0) / mass.diagonal()).max())
    shift = EIGENSOLUTION.initial_shift * largest
    while True:
        search = _ModeSearch(mass, stiffness, bodies, shift)
        low = search.low_eigenvalue()
        if low > shift or shift < EIGENSOLUTION.min_shift * largest:
            return search
        shift = max(low / EIGENSOLUTION.shift_margin, EIGENSOLUTION.min_shift * largest / 2)


class _ModeSearch:
    """Elastic modes by inverse iteration with one factorisation of K + shift M."""

    def __init__(self, mass: csc_array, stiffness: csc_array, bodies: FloatArray, shift: float) -> None:
        self.mass, self.stiffness, self.bodies, self.shift = mass, stiffness, bodies, shift
        self.elastic = mass.shape[0] - bodies.shape[1]  # number of elastic modes

    @cached_property
    def factor(self) -> SuperLU:
        """L U of K + shift M."""
        return factorised(csc_array(self.stiffness + self.shift * self.mass))

    def low_eigenvalue(self) -> float:
        """Return an estimate of the lowest elastic eigenvalues by a Rayleigh quotient."""
        motion = self._start(None)
        for _ in range(EIGENSOLUTION.inverse_iterations):
            motion = self._inverse_iteration(motion, self.bodies)
        return float(motion @ (self.stiffness @ motion) / (motion @ (self.mass @ motion)))

    def _inverse_iteration(self, motion: FloatArray, deflated: FloatArray) -> FloatArray:
        response = self.factor.solve(self.mass @ motion)
        return np.asarray(response - deflated @ (deflated.T @ (self.mass @ response)))

    def pairs(
        self, count: int, near: FloatArray | None, shapes_so_far: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the lowest eigenvalues and modes in addition to known ones, or all.

        Raises
        ------
        StructureError
            If rounding hides them.
        """
        n = len(self.bodies)
        deflated = self.bodies if shapes_so_far is None else np.hstack([self.bodies, shapes_so_far])
        if 2 * (count + deflated.shape[1]) + 1 > n:
            squares, shapes = eigh(self.stiffness.toarray(), self.mass.toarray())
            return squares[deflated.shape[1] :], shapes[:, deflated.shape[1] :]
        mass_times_deflated = self.mass @ deflated

        def inverse(load: FloatArray) -> FloatArray:
            response = self.factor.solve(load)
            return np.asarray(response - deflated @ (mass_times_deflated.T @ response))

        solve = LinearOperator((n, n), matvec=inverse, dtype=float)
        width = None if near is None else count + max(EIGENSOLUTION.spare_vectors, count // 2)
        return self._iterated(count, solve, self._start(near), width)

    def _iterated(
        self, count: int, inverse: LinearOperator, start: FloatArray, width: int | None
    ) -> tuple[FloatArray, FloatArray]:
        for accuracy in EIGENSOLUTION.tolerances:
            try:
                squares, shapes = eigsh(
                    self.stiffness,
                    count,
                    self.mass,
                    sigma=-self.shift,
                    OPinv=inverse,
                    v0=start,
                    ncv=width,
                    tol=accuracy,
                    maxiter=EIGENSOLUTION.max_restarts,
                )
            except ArpackNoConvergence:
                continue
            return np.asarray(squares), np.asarray(shapes)
        raise StructureError(
            "rounding hides the lowest modes: some stiffness is too large beside what bends in them",
            field="stiffness",
            value=float(abs(self.stiffness).max()),
            allowed="stiffnesses within about 1e15 of one another",
        )

    def _start(self, near: FloatArray | None) -> FloatArray:
        # A fixed random start: eigsh would draw another one each time, and a vector of ones would be
        # orthogonal to antisymmetric modes.
        random_motion = np.random.default_rng(0).standard_normal(len(self.bodies))
        if near is None:
            return random_motion
        flexible_motion = self._inverse_iteration(random_motion, self.bodies)
        sum_of_modes = near.sum(axis=1)
        return np.asarray(
            sum_of_modes
            + EIGENSOLUTION.random_start_fraction
            * np.abs(sum_of_modes).max()
            / np.abs(flexible_motion).max()
            * flexible_motion
        )

    def more(self, squares: FloatArray, shapes: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
        """Return the modes so far and the next `count` modes."""
        count = min(count, self.elastic - len(squares))
        new_squares, new_shapes = self.pairs(count, None, shapes)
        return np.concatenate([squares, new_squares]), np.hstack([shapes, new_shapes])

    def band(self, squares: FloatArray, shapes: FloatArray, highest: float, count: int) -> LowestModes:
        """Return all modes up to `highest`, where `count` elastic ones are expected."""
        # One starting vector yields a single mode of each multiple eigenvalue, but for rounding.
        while (missing := count - int((squares <= highest).sum())) > 0 and len(squares) < self.elastic:
            n_previous = len(squares)
            squares, shapes = self.more(squares, shapes, missing)
            if squares[n_previous:].min() > highest:
                break
        squares, shapes = _sorted(squares, shapes)
        in_band = squares <= highest
        n_rigid = self.bodies.shape[1]
        squares = np.concatenate([np.zeros(n_rigid), squares[in_band]])
        shapes = np.hstack([self.bodies, shapes[:, in_band]])
        return LowestModes(
            squares, shapes, highest, ModalTruncation(self.mass, self.factor.solve, self.shift, shapes)
        )


def _sorted(squares: FloatArray, shapes: FloatArray) -> tuple[FloatArray, FloatArray]:
    order = np.argsort(squares)
    return squares[order], shapes[:, order]
