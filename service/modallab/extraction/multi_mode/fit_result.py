"""Result of a fit of all modes to all FRFs."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen


@dataclass(frozen=True, eq=False)
class ModalFit:
    """Receptance `H_j = sum_r A_rj/(lambda_r - omega^2) + R_j - L_j/omega^2` fitted to every FRF.

    Standard errors are those of the linearised fit, widened by the misfit where that exceeds 1; of a
    complex number: of either of its parts.
    """

    eigenvalue: ComplexArray
    """(n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2, in ascending order."""
    modal_constant: ComplexArray
    """(n_modes, n_frf) 1/kg."""
    residuals: ComplexArray
    """(2, n_frf) L of modes below the range, 1/kg, and R of modes above it, m/N."""
    eigenvalue_covariance: FloatArray
    """(2 n_modes, 2 n_modes) of all frequencies, Hz, then all loss factors."""
    modal_constant_error: FloatArray
    """(n_modes, n_frf) 1/kg, standard errors."""
    misfit: FloatArray
    """(n_frf,) mean squared residual over the variance of the lines."""
    common_noise: float = 0.0
    """Part, 0 to 1, of the variance of lines near resonances that is common to all FRFs."""
    participation: ComplexArray | None = None
    """(n_modes, n_ref) participation factors, `A_jk = psi_j L_k`; None where each FRF has its own
    constant."""
    significance: FloatArray | None = None
    """(n_modes,) standard errors by which FRFs show the mode beside all others; None with one reference."""
    conditional_error: FloatArray | None = None
    """(n_modes, n_frf) 1/kg, standard errors for known poles and participation factors."""
    fixed_eigenvalue: FloatArray | None = None
    """(n_fixed,) (rad/s)^2, undamped poles fixed above the range; None without such."""
    fixed_constant: ComplexArray | None = None
    """(n_fixed, n_frf) 1/kg, their constants A in `A/(lambda - omega^2)`."""

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
        if self.fixed_eigenvalue is not None and self.fixed_constant is not None:
            fixed = frozen(self.fixed_eigenvalue, float, (None,), name="fixed_eigenvalue")
            constant = frozen(self.fixed_constant, complex, (len(fixed), shape[1]), name="fixed_constant")
            object.__setattr__(self, "fixed_eigenvalue", fixed)
            object.__setattr__(self, "fixed_constant", constant)
        if self.participation is not None:
            reach = frozen(self.participation, complex, (n, None), name="participation")
            object.__setattr__(self, "participation", reach)
        if self.significance is not None:
            object.__setattr__(
                self, "significance", frozen(self.significance, float, (n,), name="significance")
            )
        if self.conditional_error is not None:
            object.__setattr__(
                self,
                "conditional_error",
                frozen(self.conditional_error, float, shape, name="conditional_error"),
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
        # A negative variance is rounding of its size, where poles nearly depend on each other.
        return np.asarray(np.sqrt(np.abs(np.diag(self.eigenvalue_covariance))))
