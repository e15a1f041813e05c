"""Random fields: smooth deviations of the members' modulus and density along a structure."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.distance import cdist

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.settings import RANDOM_FIELD
from modallab.fe.member_table import MemberTable


@dataclass(frozen=True, eq=False)
class RandomField:
    """Karhunen-Loeve expansion of a Gaussian random field of unit variance at the members' centres.

    Source: Ghanem and Spanos, Stochastic Finite Elements (1991), section 2.3.
    """

    numbers: tuple[int, ...] = ()
    """(n_members,) numbers of the members."""
    shapes: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    """(n_shapes, n_members) eigenvectors of the covariance, times the roots of its eigenvalues."""

    @classmethod
    def of(cls, members: MemberTable) -> "RandomField":
        """Return the field with a squared exponential covariance over the distance of centres.

        Shapes of the largest variance, up to a share of the whole.
        """
        centres = members.centres
        length = RANDOM_FIELD.correlation_length * np.ptp(centres, axis=0).max() or 1.0
        covariance = np.exp(-(cdist(centres, centres) ** 2) / (2 * length**2))
        variances, vectors = (part[..., ::-1] for part in np.linalg.eigh(covariance))
        share = np.cumsum(variances) / variances.sum()
        n = min(RANDOM_FIELD.max_shapes, 1 + int(np.searchsorted(share, RANDOM_FIELD.variance_share)))
        return cls(members.numbers, np.ascontiguousarray((np.sqrt(variances[:n]) * vectors[:, :n]).T))

    def __len__(self) -> int:
        return len(self.shapes)

    def logarithms(self, standard_deviation: float, position: FloatArray) -> FloatArray:
        """Return the logarithm (n_members,) of each member's factor.

        Parameters
        ----------
        standard_deviation
            Of the logarithm.
        position
            (n_shapes,) standard normal coefficients of the shapes.
        """
        return standard_deviation * (position @ self.shapes)

    def standard_errors(self, standard_deviation: float, covariance: FloatArray) -> FloatArray:
        """Return the standard error (n_members,) of each logarithm.

        Parameters
        ----------
        standard_deviation
            Of the logarithm.
        covariance
            (n_shapes, n_shapes) of the coefficients of the shapes.
        """
        variance = np.einsum("pe,pq,qe->e", self.shapes, covariance, self.shapes)
        return np.asarray(standard_deviation * np.sqrt(variance))
