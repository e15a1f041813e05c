"""One shape a mode out of the modal constants of all references, on one scale, and how far these agree."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.correlation.complexity import phase_collinearity
from modallab.extraction.averaging.driving_point import driving_point_flags
from modallab.extraction.averaging.scaling import scaled_shapes
from modallab.extraction.preprocessing.responses import driving_rows

COMPLEX = 0.9  # phase collinearity: random error of a few per cent leaves more
ROUNDS = 20  # of alternating least squares; noise of some per cent settles in a few
ROUNDING = 1e-12  # of a mode's largest constant
APART = 0.05  # of the constants: less is left by neighbours in single-mode fits
CLEAR = 3.0  # standard errors


@dataclass(frozen=True, eq=False)
class ReferenceShapes:
    """Shapes of all modes and what is told of them."""

    dofs: tuple[Dof, ...]
    references: tuple[Dof, ...]
    shape: ComplexArray  # (n_modes, n_dof)
    error: FloatArray  # (n_modes, n_dof) standard errors of its size
    apart: FloatArray  # (n_modes,) rms of what one shape leaves of the constants, over theirs
    score: FloatArray  # (n_modes,) the same in standard errors; 1 is chance
    scale: "Scale | None"  # None without a drive point

    def odd(self, mode: int) -> Iterator[str]:
        """Yield what is unusual about a shape: its drive point, its phases, references that differ."""
        scale = self.scale
        if scale is not None:
            own, error = complex(scale.own[mode]), float(scale.own_error[mode])
            yield from driving_point_flags(own, error, self.dofs[scale.best[mode]], 1)
        shape = self.shape[mode]
        if shape.any() and (collinearity := float(phase_collinearity(shape[:, None])[0])) < COMPLEX:
            yield f"complex shape: phase collinearity {collinearity:.2f}"
        if self.apart[mode] > APART and self.score[mode] > CLEAR:
            yield (
                f"references differ: {100 * self.apart[mode]:.2g} % of the modal constants are of no one "
                f"shape, {self.score[mode]:.2g} standard errors"
            )
        if scale is not None and scale.uneven[mode] > APART and scale.score[mode] > CLEAR:
            yield f"drive points differ by {100 * scale.uneven[mode]:.2g} % about the scale of the shape"

    def said(self, fitted: str | None = None) -> dict[str, str]:
        """Return what was made of several references, and how far they agree, by option; nothing of one.

        Parameters
        ----------
        fitted
            What to say in place of how far constants are those of one shape, where they were fitted so.
        """
        if len(self.references) < 2:
            return {}
        names = ", ".join(str(dof) for dof in self.references)
        told = fitted or _told("modal constants are those of one shape", self.apart)
        if self.scale is not None:
            told += f"; {_told('drive points agree on its scale', self.scale.uneven)}"
        return {"references": f"{names}: {told}"}


@dataclass(frozen=True, eq=False)
class Scale:
    """What the drive points say of the size of shapes; every array (n_modes,)."""

    square: ComplexArray  # q^2, which makes shapes of constants; 0 where no drive point moves
    relative: FloatArray  # its standard error over its size
    uneven: FloatArray  # rms of what drive points differ by about it, over their shapes
    score: FloatArray  # the same in standard errors
    own: ComplexArray  # modal constant of the drive point that shows the mode best, both in one sense
    own_error: FloatArray  # standard error of either part
    best: IntArray  # which of the DoFs that is


def _told(what: str, share: FloatArray) -> str:
    if not len(share):
        return what
    worst = int(np.argmax(share))
    usual, most = 100 * np.median(share), 100 * share[worst]
    return f"{what} to {usual:.2g} %, at worst {most:.2g} % in mode {worst + 1}"


def reference_shapes(
    constant: ComplexArray,
    error: FloatArray,
    dofs: Sequence[Dof],
    references: Sequence[Dof],
    shared: float = 0.0,
) -> ReferenceShapes:
    """Return one shape a mode, mass-normalised where a drive point is among the DoFs.

    All constants of a mode are one product, `A_jk = psi_j L_k`, fitted by least squares weighted by standard
    errors; at drive points `L_k = q^2 psi_k`, fitted likewise, makes the scale: `phi = q psi`. A drive point
    at a node then does no harm where another is not. Of one reference it is `scaled_shapes`.

    Parameters
    ----------
    constant, error
        (n_modes, n_dof n_ref) 1/kg, DoF by DoF, and the standard error of either part.
    dofs, references
        (n_dof,) and (n_ref,).
    shared
        Correlation of the relative errors of any two constants, 0 to 1.
    """
    split = (len(constant), len(dofs), len(references))
    factors = _factored(constant.reshape(split), error.reshape(split))
    rows = driving_rows(dofs, references)
    at = np.flatnonzero(rows >= 0)
    sense = np.array([dofs[rows[k]].sign * references[k].sign for k in at.tolist()], np.int64)
    scale = _scale(factors, rows[at], at, sense) if len(at) else None
    if len(references) == 1:
        drive, turn = (None, 1) if scale is None else (int(rows[0]), int(sense[0]))
        shape, errors = scaled_shapes(constant, error, drive, turn, shared)
    elif scale is None:
        shape, errors = scaled_shapes(factors.psi, factors.psi_error, None, 1)
    else:
        shape, errors = _on(scale, factors, shared)
    return ReferenceShapes(tuple(dofs), tuple(references), shape, errors, factors.apart, factors.score, scale)


@dataclass(frozen=True, eq=False)
class _Factors:
    """Modal constants as products; errors widened by the misfit."""

    psi: ComplexArray  # (n_modes, n_dof)
    reach: ComplexArray  # (n_modes, n_ref), how strongly each reference reaches a mode, of length 1
    psi_error: FloatArray
    reach_error: FloatArray
    apart: FloatArray  # as of `ReferenceShapes`
    score: FloatArray


def _factored(constant: ComplexArray, error: FloatArray) -> _Factors:
    """Return the products nearest to the constants, (n_modes, n_dof, n_ref), by their standard errors."""
    n_modes, n_dof, n_ref = constant.shape
    if n_ref == 1:
        none = np.zeros(n_modes)
        return _Factors(
            constant[..., 0], np.ones((n_modes, 1), complex), error[..., 0], none[:, None], none, none
        )
    largest = np.abs(constant).max(axis=(1, 2), keepdims=True)
    sure = np.hypot(error, ROUNDING * np.where(largest > 0, largest, 1.0))
    weight = 1 / sure**2
    reach = np.linalg.svd(constant, full_matrices=False)[2][:, 0]
    for _ in range(ROUNDS):
        psi_power = (weight * np.abs(reach[:, None]) ** 2).sum(axis=2)
        psi = (weight * constant * reach[:, None].conj()).sum(axis=2) / psi_power
        power = (weight * np.abs(psi[:, :, None]) ** 2).sum(axis=1)
        reach = (weight * constant * psi[:, :, None].conj()).sum(axis=1) / np.where(power > 0, power, 1.0)
        length = np.linalg.norm(reach, axis=1, keepdims=True)
        reach = np.where(length > 0, reach / np.where(length > 0, length, 1.0), 1 / np.sqrt(n_ref))
    left = np.abs(constant - psi[:, :, None] * reach[:, None]) ** 2
    spare = n_dof * n_ref - n_dof - n_ref + 1
    score = np.sqrt((weight * left).sum(axis=(1, 2)) / (2 * max(spare, 1)))
    whole = (np.abs(constant) ** 2).sum(axis=(1, 2))
    wide = np.maximum(score, 1.0)[:, None]
    return _Factors(
        psi,
        reach,
        wide / np.sqrt(psi_power),
        wide / np.sqrt(np.where(power > 0, power, np.inf)),
        np.sqrt(left.sum(axis=(1, 2)) / np.where(whole > 0, whole, 1.0)),
        score,
    )


def _scale(factors: _Factors, rows: IntArray, at: IntArray, sense: IntArray) -> Scale:
    """Return the scale; `rows` of the DoFs and `at` of the references are the drive points' (n_drive,)."""
    psi, reach = factors.psi[:, rows], factors.reach[:, at] * sense
    blur = np.hypot(factors.psi_error[:, rows] * np.abs(reach), factors.reach_error[:, at] * np.abs(psi))
    # a drive point counts as it moves; of what moves alike, as it is known
    floor = 1e-6 * np.abs(psi * reach).max(axis=1, keepdims=True) + np.finfo(float).tiny
    relative = np.hypot(blur, floor) / np.where(psi != 0, np.abs(psi), 1.0)
    weight = np.where(psi != 0, 1 / relative**2, 0.0)
    power = (weight * np.abs(psi) ** 2).sum(axis=1)
    moves = power > 0
    square = (weight * psi.conj() * reach).sum(axis=1) / np.where(moves, power, 1.0)
    size = np.where(square != 0, np.abs(square), 1.0)
    expected = square[:, None] * psi
    gap, whole = np.abs(reach - expected) ** 2, (np.abs(expected) ** 2).sum(axis=1)
    score = np.sqrt((weight * gap).sum(axis=1) / (2 * max(len(at) - 1, 1)))
    error = np.maximum(score, 1.0) / np.sqrt(np.where(moves, power, 1.0)) / size
    strongest = np.abs(psi * reach).argmax(axis=1)
    modes = np.arange(len(psi))
    return Scale(
        square=square,
        relative=error,
        uneven=np.sqrt(gap.sum(axis=1) / np.where(whole > 0, whole, 1.0)),
        score=score,
        own=(psi * reach)[modes, strongest],
        own_error=blur[modes, strongest],
        best=rows[strongest],
    )


def _on(scale: Scale, factors: _Factors, shared: float) -> tuple[ComplexArray, FloatArray]:
    """Return mass-normalised shapes and the errors of their size; zeros where no drive point moves.

    Their sign is that of one reference: at the drive point that shows a mode best its real part is positive.
    """
    q = np.sqrt(scale.square)[:, None]
    shape = q * factors.psi
    best = shape[np.arange(len(shape)), scale.best]
    local, common = np.abs(q) * factors.psi_error, np.abs(shape) * scale.relative[:, None] / 2
    error = np.sqrt(np.maximum(local**2 + common**2 - 2 * shared * local * common, 0.0))
    return shape * np.where(best.real < 0, -1.0, 1.0)[:, None], np.where(q != 0, error, 0.0)
