"""Mass-normalised shapes from the modal constants of all references, and their consistency."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.correlation.complexity import phase_collinearity
from modallab.extraction.averaging.driving_point import driving_point_flags
from modallab.extraction.averaging.scaling import scaled_shapes
from modallab.extraction.averaging.settings import REFERENCE_SHAPES
from modallab.extraction.preprocessing.responses import driving_rows


@dataclass(frozen=True, eq=False)
class ReferenceShapes:
    """Shapes of all modes, and the consistency of the references."""

    dofs: tuple[Dof, ...]
    """(n_dof,) measured degrees of freedom."""
    references: tuple[Dof, ...]
    """(n_ref,) reference degrees of freedom."""
    shape: ComplexArray
    """(n_modes, n_dof)."""
    error: FloatArray
    """(n_modes, n_dof) standard errors of the modulus."""
    inconsistency: FloatArray
    """(n_modes,) root mean square of the constants that one shape does not explain, over theirs."""
    score: FloatArray
    """(n_modes,) the same in standard errors; 1 for random error only."""
    scale: "Scale | None"
    """None without a drive point."""

    def flags(self, mode: int) -> Iterator[str]:
        """Yield flags on a shape: its drive point, its phases, inconsistent references."""
        scale = self.scale
        if scale is not None:
            constant, error = complex(scale.drive_constant[mode]), float(scale.drive_constant_error[mode])
            yield from driving_point_flags(constant, error, self.dofs[scale.best[mode]], 1)
        shape = self.shape[mode]
        if (
            shape.any()
            and (collinearity := float(phase_collinearity(shape[:, None])[0]))
            < REFERENCE_SHAPES.smallest_collinearity
        ):
            yield f"complex shape: phase collinearity {collinearity:.2f}"
        if (
            self.inconsistency[mode] > REFERENCE_SHAPES.inconsistency
            and self.score[mode] > REFERENCE_SHAPES.inconsistency_errors
        ):
            yield (
                f"references differ: modal constants deviate from one common shape by "
                f"{100 * self.inconsistency[mode]:.2g} %, {self.score[mode]:.2g} standard errors"
            )
        if (
            scale is not None
            and scale.inconsistency[mode] > REFERENCE_SHAPES.inconsistency
            and scale.score[mode] > REFERENCE_SHAPES.inconsistency_errors
        ):
            percent = 100 * scale.inconsistency[mode]
            yield f"drive points differ by {percent:.2g} % in the scale of the shape"

    def choice_text(self, fitted: str | None = None) -> dict[str, str]:
        """Return the treatment of several references and their consistency; empty for one reference.

        Parameters
        ----------
        fitted
            Text that replaces the consistency of the constants where they were fitted as products.
        """
        if len(self.references) < 2:
            return {}
        names = ", ".join(str(dof) for dof in self.references)
        text = fitted or _agreement_text("modal constants agree with one shape", self.inconsistency)
        if self.scale is not None:
            text += f"; {_agreement_text('drive points agree on its scale', self.scale.inconsistency)}"
        return {"references": f"{names}: {text}"}


@dataclass(frozen=True, eq=False)
class Scale:
    """Scale of shapes from the drive points; every array (n_modes,)."""

    square: ComplexArray
    """q^2, which scales constants to shapes; 0 where no drive point moves."""
    relative: FloatArray
    """Standard error over its modulus."""
    inconsistency: FloatArray
    """Root mean square of the differences between drive points over their shapes."""
    score: FloatArray
    """The same in standard errors."""
    drive_constant: (
        ComplexArray  # modal constant of the drive point that shows the mode best, both in one sense
    )
    """Modal constant of the drive point that shows the mode best, in equal directions."""
    drive_constant_error: FloatArray
    """Standard error of real and imaginary part."""
    best: IntArray
    """Index of the DoF of that drive point."""


def _agreement_text(statement: str, share: FloatArray) -> str:
    if not len(share):
        return statement
    worst = int(np.argmax(share))
    usual, most = 100 * np.median(share), 100 * share[worst]
    return f"{statement} to {usual:.2g} % (median), at worst {most:.2g} % in mode {worst + 1}"


def reference_shapes(
    constant: ComplexArray,
    error: FloatArray,
    dofs: Sequence[Dof],
    references: Sequence[Dof],
    noise_correlation: FloatArray | float = 0.0,
) -> ReferenceShapes:
    """Return one shape for each mode, mass-normalised where a drive point is among the DoFs.

    The constants of a mode are a product `A_jk = psi_j L_k`, fitted by least squares weighted by standard
    errors. At drive points `L_k = q^2 psi_k`, fitted likewise, gives the scale: `phi = q psi`. A drive point
    at a node does no harm if another is not. With one reference the result is that of `scaled_shapes`.

    Parameters
    ----------
    constant, error
        (n_modes, n_dof n_ref) 1/kg, DoF by DoF, and the standard error of real and imaginary part.
    dofs, references
        (n_dof,) and (n_ref,).
    noise_correlation
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
        shape, errors = scaled_shapes(constant, error, drive, turn, noise_correlation)
    elif scale is None:
        shape, errors = scaled_shapes(factors.psi, factors.psi_error, None, 1)
    else:
        shape, errors = _mass_normalised_shapes(scale, factors, noise_correlation)
    return ReferenceShapes(
        tuple(dofs), tuple(references), shape, errors, factors.inconsistency, factors.score, scale
    )


@dataclass(frozen=True, eq=False)
class _Factors:
    """Modal constants as products; errors include the misfit."""

    psi: ComplexArray
    """(n_modes, n_dof) shapes."""
    participation: ComplexArray
    """(n_modes, n_ref) participation factors, of length 1."""
    psi_error: FloatArray
    """(n_modes, n_dof) standard errors."""
    participation_error: FloatArray
    """(n_modes, n_ref) standard errors."""
    inconsistency: FloatArray
    """(n_modes,) as in `ReferenceShapes`."""
    score: FloatArray
    """(n_modes,) as in `ReferenceShapes`."""


def _factored(constant: ComplexArray, error: FloatArray) -> _Factors:
    """Return the products nearest to the constants, (n_modes, n_dof, n_ref), by alternating least squares."""
    n_modes, n_dof, n_ref = constant.shape
    if n_ref == 1:
        zeros = np.zeros(n_modes)
        return _Factors(
            constant[..., 0], np.ones((n_modes, 1), complex), error[..., 0], zeros[:, None], zeros, zeros
        )
    largest = np.abs(constant).max(axis=(1, 2), keepdims=True)
    bounded_error = np.hypot(error, PRODUCT_ROUNDING * np.where(largest > 0, largest, 1.0))
    weight = 1 / bounded_error**2
    participation = np.linalg.svd(constant, full_matrices=False)[2][:, 0]
    for _ in range(REFERENCE_SHAPES.iterations):
        psi_power = (weight * np.abs(participation[:, None]) ** 2).sum(axis=2)
        psi = (weight * constant * participation[:, None].conj()).sum(axis=2) / psi_power
        power = (weight * np.abs(psi[:, :, None]) ** 2).sum(axis=1)
        participation = (weight * constant * psi[:, :, None].conj()).sum(axis=1) / np.where(
            power > 0, power, 1.0
        )
        length = np.linalg.norm(participation, axis=1, keepdims=True)
        participation = np.where(
            length > 0, participation / np.where(length > 0, length, 1.0), 1 / np.sqrt(n_ref)
        )
    misfit = np.abs(constant - psi[:, :, None] * participation[:, None]) ** 2
    spare = n_dof * n_ref - n_dof - n_ref + 1
    score = np.sqrt((weight * misfit).sum(axis=(1, 2)) / (2 * max(spare, 1)))
    total_power = (np.abs(constant) ** 2).sum(axis=(1, 2))
    wide = np.maximum(score, 1.0)[:, None]
    return _Factors(
        psi,
        participation,
        wide / np.sqrt(psi_power),
        wide / np.sqrt(np.where(power > 0, power, np.inf)),
        np.sqrt(misfit.sum(axis=(1, 2)) / np.where(total_power > 0, total_power, 1.0)),
        score,
    )


def _scale(factors: _Factors, rows: IntArray, at: IntArray, sense: IntArray) -> Scale:
    """Return the scale; `rows` of the DoFs and `at` of the references are the drive points' (n_drive,)."""
    psi, participation = factors.psi[:, rows], factors.participation[:, at] * sense
    blur = np.hypot(
        factors.psi_error[:, rows] * np.abs(participation), factors.participation_error[:, at] * np.abs(psi)
    )
    # weights follow the motion of a drive point, and its precision
    floor = (
        REFERENCE_SHAPES.least_relative_error * np.abs(psi * participation).max(axis=1, keepdims=True)
        + np.finfo(float).tiny
    )
    relative = np.hypot(blur, floor) / np.where(psi != 0, np.abs(psi), 1.0)
    weight = np.where(psi != 0, 1 / relative**2, 0.0)
    power = (weight * np.abs(psi) ** 2).sum(axis=1)
    moves = power > 0
    square = (weight * psi.conj() * participation).sum(axis=1) / np.where(moves, power, 1.0)
    size = np.where(square != 0, np.abs(square), 1.0)
    expected = square[:, None] * psi
    gap, total_power = np.abs(participation - expected) ** 2, (np.abs(expected) ** 2).sum(axis=1)
    score = np.sqrt((weight * gap).sum(axis=1) / (2 * max(len(at) - 1, 1)))
    error = np.maximum(score, 1.0) / np.sqrt(np.where(moves, power, 1.0)) / size
    strongest = np.abs(psi * participation).argmax(axis=1)
    modes = np.arange(len(psi))
    return Scale(
        square=square,
        relative=error,
        inconsistency=np.sqrt(gap.sum(axis=1) / np.where(total_power > 0, total_power, 1.0)),
        score=score,
        drive_constant=(psi * participation)[modes, strongest],
        drive_constant_error=blur[modes, strongest],
        best=rows[strongest],
    )


def _mass_normalised_shapes(
    scale: Scale, factors: _Factors, noise_correlation: FloatArray | float
) -> tuple[ComplexArray, FloatArray]:
    """Return mass-normalised shapes and the errors of their modulus; zeros where no drive point moves.

    The real part is positive at the drive point that shows the mode best.
    """
    q = np.sqrt(scale.square)[:, None]
    shape = q * factors.psi
    best = shape[np.arange(len(shape)), scale.best]
    local, common = np.abs(q) * factors.psi_error, np.abs(shape) * scale.relative[:, None] / 2
    error = np.sqrt(np.maximum(local**2 + common**2 - 2 * noise_correlation * local * common, 0.0))
    return shape * np.where(best.real < 0, -1.0, 1.0)[:, None], np.where(q != 0, error, 0.0)
