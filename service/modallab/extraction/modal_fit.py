"""All modes in all FRFs at once, by weighted least squares, with their covariance."""

from dataclasses import dataclass

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
