"""Arrays of updates: covariance, posterior draws and matrices."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from modallab_client.models import FloatArray


@dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of coefficients by the errors of the data."""

    coefficients: tuple[str, ...]
    """(n_params,) names such as `mass of 3`."""
    intervals: FloatArray
    """(n_params, 2) 95 % confidence intervals."""
    covariance: FloatArray | None
    """(n_params, n_params) covariance; None without an error estimate."""


@dataclass(frozen=True, eq=False)
class PosteriorDraws:
    """Draws of coefficients from the posterior."""

    coefficients: tuple[str, ...]
    """(n_free,) names such as `mass of 3`."""
    draws: FloatArray
    """(n_draws, n_free) coefficients."""
    log_density: FloatArray
    """(n_draws,) logarithm of the posterior density, up to a constant."""


@dataclass(frozen=True, eq=False)
class UpdatedMatrices:
    """Matrices of a direct method; None for those that it does not have."""

    dofs: tuple[str, ...]
    """(n,) degrees of freedom."""
    mass: FloatArray | None
    """kg, (n, n) updated mass matrix."""
    stiffness: FloatArray | None
    """N/m, (n, n) updated stiffness matrix."""
    mass_error: FloatArray | None
    """kg, (n, n) correction, or estimated error, of the mass matrix."""
    stiffness_error: FloatArray | None
    """N/m, (n, n) correction, or estimated error, of the stiffness matrix."""
    force_balance: FloatArray | None
    """(n, n) residual forces of the measured modes."""


Arrays = Mapping[str, NDArray[Any]]


_MATRICES = ("mass", "stiffness", "mass_error", "stiffness_error", "force_balance")


def covariance_of(arrays: Arrays) -> Covariance:
    """Return the covariance of an update's coefficients from the arrays of an npz file."""
    return Covariance(_texts(arrays["coefficients"]), arrays["intervals"], arrays.get("covariance"))


def draws_of(arrays: Arrays) -> PosteriorDraws:
    """Return draws from the posterior of an update from the arrays of an npz file."""
    return PosteriorDraws(_texts(arrays["coefficients"]), arrays["draws"], arrays["log_density"])


def matrices_of(arrays: Arrays) -> UpdatedMatrices:
    """Return the matrices of a direct method from the arrays of an npz file."""
    matrices = {name: arrays.get(name) for name in _MATRICES}
    return UpdatedMatrices(dofs=_texts(arrays["dofs"]), **matrices)


def _texts(names: NDArray[Any]) -> tuple[str, ...]:
    return tuple(map(str, names))
