"""Damping that is known mode by mode."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.fe.attachment import Attachment


@dataclass(frozen=True)
class ModalLoss:
    """Loss factors of the elastic modes in rising order; the last one holds for every mode above.

    D = M Phi diag(structural eta_r lambda_r) Phi^T M and C of the same form, which leave modes as they are.
    """

    loss_factors: tuple[float, ...]
    structural: float = 1.0
    viscous: float = 0.0  # s

    def scaled(self, factor: float) -> "ModalLoss":
        """Return it multiplied."""
        return ModalLoss(self.loss_factors, factor * self.structural, factor * self.viscous)

    def to_viscous(self, share: float, omega: float) -> "ModalLoss":
        """Return it with a share of the hysteretic part viscous, alike at `omega` rad/s."""
        gained = share / omega * self.structural
        return ModalLoss(self.loss_factors, (1 - share) * self.structural, self.viscous + gained)

    def lost(self, squares: FloatArray) -> FloatArray:
        """Return eta_r lambda_r of elastic modes from their lambda_r in rising order, (m,) rad^2/s^2."""
        etas = np.full(len(squares), self.loss_factors[-1])
        etas[: len(self.loss_factors)] = self.loss_factors[: len(squares)]
        return np.asarray(etas * squares)

    def attachment(self, mass: csc_array, squares: FloatArray, shapes: FloatArray) -> Attachment:
        """Return it hung on the undamped elastic modes (m,), (n, m) of a structure of that mass."""
        lost = np.diag(self.lost(squares))
        return Attachment(mass @ shapes, damping=self.structural * lost, viscous=self.viscous * lost)
