"""Attachment: a small dynamic system added to motions of a structure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.settings import CACHE, RECEPTANCE

MATRIX_NAMES = ("mass", "stiffness", "damping", "viscous")
DYNAMIC_STIFFNESS: CacheSlot[ComplexArray] = CacheSlot("dynamic stiffness", CACHE.frequency_axes)


@dataclass(frozen=True, eq=False)
class Attachment:
    """A small dynamic system attached to motions of the structure: q = columns^T x.

    It adds `columns Z columns^T` to the dynamic stiffness, with Z = k + i d + i omega c - omega^2 m.
    Its matrices are (r + inner, r + inner): the last `inner` coordinates are internal, such as that of an
    oscillator's mass, and Z is condensed to the others, with no force on the internal ones.
    """

    columns: FloatArray  # (n, r)
    mass: FloatArray | None = None
    stiffness: FloatArray | None = None
    damping: FloatArray | None = None  # structural
    viscous: FloatArray | None = None
    inner: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", frozen(self.columns, float, (None, None), name="columns"))
        r = self.columns.shape[1] + self.inner
        for name in MATRIX_NAMES:
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen(value, float, (r, r), name=name))

    @property
    def is_constant(self) -> bool:
        """Whether constant matrices without internal coordinates describe it."""
        return self.inner == 0

    def equals(self, attachment: "Attachment") -> bool:
        """Return whether another attachment is equal to this one."""
        return self is attachment or self.key == attachment.key

    @cached_property
    def key(self) -> tuple[object, ...]:
        """All values, bit by bit: equal for equal attachments."""
        parts = (self.columns, self.mass, self.stiffness, self.damping, self.viscous)
        return self.inner, *(None if part is None else (part.shape, part.tobytes()) for part in parts)

    def dynamic_stiffness(self, omega: FloatArray) -> ComplexArray:
        """Return Z, (n_freq, r, r), N/m, at `omega` (n_freq,) rad/s.

        The result is cached for each frequency axis; all runs of a test have the same axis.
        """
        if len(omega) * self.columns.shape[1] ** 2 > CACHE.dynamic_stiffness_values:
            return self._stiffness(omega)
        return self._cache.compute(DYNAMIC_STIFFNESS, omega.tobytes(), lambda: self._stiffness(omega))

    @cached_property
    def _cache(self) -> Cache:
        return Cache()

    def _stiffness(self, omega: FloatArray) -> ComplexArray:
        z: ComplexArray = dynamic_stiffnesses([self], omega)[0]
        z.flags.writeable = False
        return z


def dynamic_stiffnesses(attachments: Sequence[Attachment], omega: FloatArray) -> ComplexArray:
    """Return the dynamic stiffness of attachments of equal size, (n, n_freq, r, r), N/m."""
    if not all(a.is_constant or a.inner for a in attachments):
        return np.array([a.dynamic_stiffness(omega) for a in attachments])
    inner, r = attachments[0].inner, attachments[0].columns.shape[1]
    z = np.zeros((len(attachments), len(omega), r + inner, r + inner), complex)
    w, zeros = omega[:, None, None], np.zeros(z.shape[2:])
    for name, factor in (("mass", -(w**2)), ("stiffness", 1.0), ("damping", 1j), ("viscous", 1j * w)):
        matrices = [getattr(a, name) for a in attachments]
        if any(matrix is not None for matrix in matrices):
            z += factor * np.array([zeros if matrix is None else matrix for matrix in matrices])[:, None]
    return z if inner == 0 else _condensed(z, inner)


def point_mass(columns: FloatArray, mass: float) -> Attachment:
    """Return a mass, kg, that moves with each of some motions (n, r)."""
    return Attachment(columns, mass=mass * np.eye(columns.shape[1]))


def spring(column: FloatArray, stiffness: float) -> Attachment:
    """Return a spring, N/m (N m for a rotation), from a motion (n, 1) to the ground."""
    return Attachment(column, stiffness=np.array([[stiffness]]))


def damper(column: FloatArray, viscous: float) -> Attachment:
    """Return a viscous damper, N s/m (N m s for a rotation), from a motion (n, 1) to the ground."""
    return Attachment(column, viscous=np.array([[viscous]]))


def oscillator(
    column: FloatArray, mass: float, frequency: float, loss_factor: float, damping_ratio: float = 0.0
) -> Attachment:
    """Return a mass, kg, on a damped spring attached to a motion (n, 1); Hz, with that motion fixed."""
    omega = 2 * np.pi * frequency
    between = omega**2 * mass * np.array([[1.0, -1.0], [-1.0, 1.0]])
    viscous = 2 * damping_ratio / omega * between if damping_ratio else None
    return Attachment(column, np.diag([0.0, mass]), between, loss_factor * between, viscous, inner=1)


def _condensed(z: ComplexArray, inner: int) -> ComplexArray:
    """Return z (..., r + inner, r + inner) condensed to its first r coordinates; no force on the others."""
    outer, to_outer, from_outer = z[..., :-inner, :-inner], z[..., :-inner, -inner:], z[..., -inner:, :-inner]
    internal = z[..., -inner:, -inner:]
    return np.asarray(
        outer - to_outer @ (from_outer / internal if inner == 1 else np.linalg.solve(internal, from_outer))
    )


def extended_columns(n: int, attachments: tuple[Attachment, ...]) -> list[FloatArray]:
    """Return the (n + all inner, r + inner) columns of each attachment, internal coordinates last."""
    out, first = [], n
    for a in attachments:
        columns = np.zeros((n + sum(b.inner for b in attachments), a.columns.shape[1] + a.inner))
        columns[:n, : a.columns.shape[1]] = a.columns
        columns[first + np.arange(a.inner), a.columns.shape[1] + np.arange(a.inner)] = 1.0
        out.append(columns)
        first += a.inner
    return out


def padded(matrix: csc_array | None, n: int) -> csc_array | None:
    """Return a matrix padded with empty rows and columns to (n, n)."""
    if matrix is None or matrix.shape[0] == n:
        return matrix
    padded = matrix.tocoo()
    return csc_array((padded.data, (padded.row, padded.col)), shape=(n, n))


def with_blocks(
    matrix: csc_array | None, blocks: Sequence[tuple[FloatArray, FloatArray]], n: int
) -> csc_array | None:
    """Return a matrix (n, n) with blocks (r, r) added along columns (n, r); None without any."""
    if not blocks:
        return matrix
    if n > RECEPTANCE.dense_assembly_dofs:
        for columns, block in blocks:
            extra = csc_array(columns @ block @ columns.T)
            matrix = extra if matrix is None else csc_array(matrix + extra)
        return matrix
    # For a small structure full matrices are faster than sparse ones.
    total = np.zeros((n, n)) if matrix is None else matrix.toarray()
    for columns, block in blocks:
        total += columns @ block @ columns.T
    return csc_array(total)


def with_attachments(
    matrices: Mapping[str, csc_array | None], n: int, attachments: tuple[Attachment, ...]
) -> dict[str, csc_array | None]:
    """Return matrices (n, n) by name with attachments added, internal coordinates in rows after the `n`."""
    columns_of = extended_columns(n, attachments)
    size = n + sum(a.inner for a in attachments)
    out = {}
    for name, matrix in matrices.items():
        blocks = [
            (columns, block)
            for attachment, columns in zip(attachments, columns_of, strict=True)
            if (block := getattr(attachment, name)) is not None and block.any()
        ]
        out[name] = with_blocks(padded(matrix, size), blocks, size)
    return out


def with_internal_motions(shapes: FloatArray, attachments: tuple[Attachment, ...]) -> FloatArray:
    """Return slow motions (n, k) with the attachments' internal coordinates below them."""
    rows = [shapes]
    for a in attachments:
        if a.inner:
            k = np.zeros((a.inner, len(a.columns.T) + a.inner)) if a.stiffness is None else a.stiffness
            internal, coupling = k[-a.inner :, -a.inner :], k[-a.inner :, : -a.inner]
            rows.append(-np.linalg.pinv(internal) @ coupling @ (a.columns.T @ shapes))
    return np.vstack(rows)


def stacked_columns(n: int, attachments: Sequence[Attachment]) -> FloatArray:
    """Return the columns of attachments to a structure of `n` DoFs side by side, (n, R)."""
    return np.hstack([np.zeros((n, 0)), *(a.columns for a in attachments)])


def attached_stiffness(attachments: Sequence[Attachment], omega: FloatArray) -> ComplexArray:
    """Return the dynamic stiffness of attachments block by block, (n_freq, R, R), N/m."""
    if len(attachments) == 1:
        return attachments[0].dynamic_stiffness(omega)
    blocks = [a.dynamic_stiffness(omega) for a in attachments]
    sizes = [block.shape[1] for block in blocks]
    out = np.zeros((len(omega), sum(sizes), sum(sizes)), complex)
    start = 0
    for block, size in zip(blocks, sizes, strict=True):
        out[:, start : start + size, start : start + size] = block
        start += size
    return out


def unique_columns(columns: FloatArray) -> tuple[FloatArray, list[int]]:
    """Return the distinct columns of (n, k), and the index of each column among them."""
    index: dict[bytes, int] = {}
    place = [index.setdefault(column.tobytes(), len(index)) for column in columns.T]
    return columns[:, [place.index(i) for i in range(len(index))]], place


def merged(attachments: Sequence[Attachment]) -> tuple[Attachment, ...]:
    """Return equivalent attachments: all of constant matrices merged into one, each motion once."""
    plain = [a for a in attachments if a.is_constant]
    if not plain:
        return tuple(attachments)
    columns, place = unique_columns(np.hstack([a.columns for a in plain]))
    total: dict[str, FloatArray] = {}
    first = 0
    for a in plain:
        rows = place[first : first + a.columns.shape[1]]
        first += len(rows)
        for name in MATRIX_NAMES:
            if (block := getattr(a, name)) is not None:
                matrix = total.setdefault(name, np.zeros((columns.shape[1],) * 2))
                np.add.at(matrix, np.ix_(rows, rows), block)
    attachment = Attachment(columns, **total)  # type: ignore[arg-type]
    return attachment, *(a for a in attachments if not a.is_constant)
