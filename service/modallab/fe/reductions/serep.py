"""System equivalent reduction-expansion process."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, UnderdeterminedError, bounds
from modallab.core.parameters import parameter
from modallab.fe.partition import Partition
from modallab.fe.reduction import REDUCTIONS, Reduction
from modallab.fe.settings import REDUCTION


@REDUCTIONS.register("serep")
@dataclass(frozen=True)
class Serep(Reduction):
    """Transformation by the lowest modes of the model: T = Phi Phi_m^+.

    Exact for the selected modes, visible rigid-body modes among them; other motion of the masters is
    fitted by least squares. O'Callahan, J., Avitabile, P. and Riemer, R. (1989), Proc.
    7th International Modal Analysis Conference, 29-37.
    """

    kind = "serep"
    summary = "all DoFs follow the lowest modes of the model: exact for these modes"
    modes: float = parameter(
        0.0,
        unit="1",
        lower=0.0,
        upper=500.0,
        absent=None,
        doc="elastic modes kept; 0: those of the band, as many as the masters tell apart",
    )
    highest: float = np.inf  # Hz, highest frequency of modes selected by default

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.modes != int(self.modes):
            raise InvalidInputError(
                "modes are counted", field="modes", value=self.modes, allowed=bounds(0, 500, unit="modes")
            )

    def transformation(self, split: Partition) -> FloatArray:
        """Return the transformation T from master DoFs to all DoFs, (n, n_master)."""
        shapes, n_rigid_body = self._candidates(split)
        n_modes = self._n_selected(shapes[split.rows], n_rigid_body)
        return np.asarray(shapes[:, :n_modes] @ np.linalg.pinv(shapes[split.rows, :n_modes]))

    def reaching(self, frequency: float) -> Self:
        """Return the reduction to modes of the band up to `frequency`, Hz, unless it has a number of its own.

        Higher modes would fit errors of the measurement only.
        """
        return self if self.modes else replace(self, highest=REDUCTION.serep_band_margin * frequency)

    def _candidates(self, split: Partition) -> tuple[FloatArray, int]:
        """Return rigid-body modes visible at the masters and elastic modes, and the number of the former."""
        count = int(self.modes) or min(len(split.rows), REDUCTION.serep_max_modes)
        basis = split.lowest(count, np.inf if self.modes else self.highest)
        n_rigid_body = basis.n_rigid_body
        rigid = basis.shapes[:, :n_rigid_body].real
        if not self.modes:
            within = int((basis.frequencies[n_rigid_body:] <= self.highest).sum())
            count = min(count, max(within, 1))
        elastic = basis.shapes[:, n_rigid_body : n_rigid_body + count].real
        # Motions without master displacement are excluded, such as axial motion with transverse sensors.
        _, size, rotation = np.linalg.svd(rigid[split.rows], full_matrices=True)
        visible = size > REDUCTION.min_master_motion * np.abs(rigid).max(initial=0.0)
        rigid = rigid @ rotation[: len(size)][visible].T
        return np.hstack([rigid, elastic]), rigid.shape[1]

    def _n_selected(self, shapes: FloatArray, n_rigid_body: int) -> int:
        """Return the number of selected candidate modes, (n_master, n_modes) at the masters."""
        n_masters, n_modes = shapes.shape
        if self.modes:
            if n_modes > n_masters:
                raise UnderdeterminedError(
                    f"{n_masters} masters cannot follow {n_modes} modes, {n_rigid_body} of them rigid",
                    field="modes",
                    value=int(self.modes),
                    allowed=bounds(maximum=n_masters - n_rigid_body),
                )
            if not _condition(shapes) < REDUCTION.serep_max_condition:
                raise self._indistinct(n_modes - n_rigid_body, n_masters)
            return int(n_modes)
        count = 0
        while (
            count < min(n_modes, n_masters)
            and _condition(shapes[:, : count + 1]) < REDUCTION.serep_distinct_condition
        ):
            count += 1
        if count <= n_rigid_body:
            raise self._indistinct(1, n_masters)
        return count

    def _indistinct(self, n_elastic: int, n_masters: int) -> UnderdeterminedError:
        modes = "mode" if n_elastic == 1 else f"{n_elastic} modes"
        return UnderdeterminedError(
            f"the {n_masters} masters do not tell the first {modes} of the model apart",
            field="reduction",
            value="serep",
            allowed="more masters, or masters that move in these modes",
        )


def _condition(shapes: FloatArray) -> float:
    """Return the condition number of modes at the masters, each to its own size."""
    size = np.linalg.norm(shapes, axis=0)
    if not size.all():
        return np.inf
    return float(np.linalg.cond(shapes / size))
