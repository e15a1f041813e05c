"""All modes in all FRFs, as one fit has them."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen


@dataclass(frozen=True, eq=False)
class ModalFit:
    """Receptance `H_j = sum_r A_rj/(lambda_r - omega^2) + R_j - L_j/omega^2` fitted to every FRF.

    Standard errors are those of the linearised fit, widened by the misfit where that exceeds 1; of a
    complex number: of either of its parts.
    """

    eigenvalue: ComplexArray  # (n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2, rising
    modal_constant: ComplexArray  # (n_modes, n_frf) 1/kg
    residuals: ComplexArray  # (2, n_frf) L below the range, 1/kg, and R above it, m/N
    eigenvalue_covariance: FloatArray  # (2 n_modes, 2 n_modes) of all frequencies, Hz, then all loss factors
    modal_constant_error: FloatArray  # (n_modes, n_frf) 1/kg
    misfit: FloatArray  # (n_frf,) mean square residual over the lines' variance
    # share of the least random error at each line that all FRFs have in common, from 0 to 1
    common_noise: float = 0.0
    # (n_modes, n_ref) how strongly each reference reaches a mode, `A_jk = psi_j L_k`; None where each FRF has
    # a modal constant of its own
    participation: ComplexArray | None = None
    # (n_modes,) standard errors by which FRFs show it beside all others; None with one reference
    significance: FloatArray | None = None
    conditional_error: FloatArray | None = (
        None  # (n_modes, n_frf) 1/kg, as if poles and participations were known
    )

    def __post_init__(self) -> None:
        n, shape = len(self.eigenvalue), self.modal_constant.shape
        covariance = frozen(self.eigenvalue_covariance, float, (2 * n, 2 * n), name="eigenvalue_covariance")
        object.__setattr__(self, "eigenvalue_covariance", covariance)
        for name, of, size in (
            ("eigenvalue", complex, (n,)),
            ("modal_constant", complex, (n, None)),
            ("residuals", complex, (2, shape[1])),
            ("modal_constant_error", float, shape),
            ("misfit", float, shape[1:]),
        ):
            object.__setattr__(self, name, frozen(getattr(self, name), of, size, name=name))
        if self.participation is not None:
            reach = frozen(self.participation, complex, (n, None), name="participation")
            object.__setattr__(self, "participation", reach)
        if self.significance is not None:
            object.__setattr__(self, "clear", frozen(self.significance, float, (n,), name="clear"))
        if self.conditional_error is not None:
            object.__setattr__(
                self, "held_error", frozen(self.conditional_error, float, shape, name="held_error")
            )

    @property
    def frequency(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.asarray(np.sqrt(self.eigenvalue.real) / (2 * np.pi))

    @property
    def loss_factor(self) -> FloatArray:
        """(n_modes,)."""
        return np.asarray(self.eigenvalue.imag / self.eigenvalue.real)

    @property
    def frequency_error(self) -> FloatArray:
        """(n_modes,) Hz."""
        return self._errors[: len(self.eigenvalue)]

    @property
    def loss_factor_error(self) -> FloatArray:
        """(n_modes,)."""
        return self._errors[len(self.eigenvalue) :]

    @property
    def _errors(self) -> FloatArray:
        return np.asarray(np.sqrt(np.maximum(np.diag(self.eigenvalue_covariance), 0.0)))
