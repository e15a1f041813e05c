"""Modal damping: loss factors by mode."""

from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.fe.attachment import Attachment


@dataclass(frozen=True)
class ModalLossFactors:
    """Loss factors of the elastic modes in rising order; the last one is that of all higher modes.

    D = M Phi diag(structural eta_r lambda_r) Phi^T M and C of the same form, which keep shapes real.
    """

    loss_factors: tuple[float, ...]
    structural: float = 1.0
    viscous: float = 0.0  # s
    more: tuple[float, ...] = ()  # additional loss factors of the lowest elastic modes

    def scaled(self, factor: float) -> "ModalLossFactors":
        """Return modal damping multiplied by a factor."""
        return replace(self, structural=factor * self.structural, viscous=factor * self.viscous)

    def with_modal_loss(self, more: tuple[float, ...]) -> "ModalLossFactors":
        """Return modal damping with additional loss factors of the lowest modes, under the same law."""
        pairs = zip_longest(self.more, more, fillvalue=0.0)
        return replace(self, more=tuple(a + b for a, b in pairs))

    def to_viscous(self, share: float, omega: float) -> "ModalLossFactors":
        """Return modal damping with a fraction of it made viscous, equal at `omega` rad/s."""
        gained = share / omega * self.structural
        return replace(self, structural=(1 - share) * self.structural, viscous=self.viscous + gained)

    def modal_loss(self, squares: FloatArray) -> FloatArray:
        """Return eta_r lambda_r of elastic modes from their lambda_r in rising order, (m,) rad^2/s^2."""
        etas = np.full(len(squares), self.loss_factors[-1])
        etas[: len(self.loss_factors)] = self.loss_factors[: len(squares)]
        n = min(len(self.more), len(squares))
        etas[:n] += self.more[:n]
        return np.asarray(etas * squares)

    def hysteretic(self, squares: FloatArray) -> FloatArray:
        """Return eta_r lambda_r of structural damping from lambda_r in rising order, (m,) rad^2/s^2."""
        return np.asarray(self.structural * self.modal_loss(squares))

    def attachment(self, mass: csc_array, squares: FloatArray, shapes: FloatArray) -> Attachment:
        """Return modal damping as an attachment to the undamped elastic modes (m,), (n, m) of a structure."""
        return Attachment(
            mass @ shapes,
            damping=np.diag(self.hysteretic(squares)),
            viscous=np.diag(self.viscous * self.modal_loss(squares)),
        )
