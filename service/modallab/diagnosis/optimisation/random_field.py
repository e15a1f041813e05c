"""Random fields: smooth deviations of the members' modulus and density along a structure."""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
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
    n_large: int = 0
    """Shapes of large variance, the first ones; the others are seen where noise is low."""

    @classmethod
    def of(cls, members: MemberTable, standard_deviation: float) -> "RandomField":
        """Return the field with a squared exponential covariance over the distance of centres.

        Different bars of a frame are independent: each was made for itself. The shapes of largest variance
        are retained, until what they omit is below the noise of any test.

        Parameters
        ----------
        standard_deviation
            Largest one of the logarithms that the field is used for.
        """
        centres = members.centres
        length = RANDOM_FIELD.correlation_length * np.ptp(centres, axis=0).max() or 1.0
        bar = _bar_indices(members)
        covariance = np.exp(-(cdist(centres, centres) ** 2) / (2 * length**2)) * (bar[:, None] == bar)
        variances, vectors = (part[..., ::-1] for part in np.linalg.eigh(covariance))
        omitted = standard_deviation**2 * (1 - np.cumsum(variances) / variances.sum())
        n_large, n = (
            min(RANDOM_FIELD.max_shapes, 1 + int(np.argmax(omitted < deviation**2)))
            for deviation in (RANDOM_FIELD.small_deviation, RANDOM_FIELD.omitted_deviation)
        )
        shapes = (np.sqrt(np.maximum(variances[:n], 0)) * vectors[:, :n]).T
        return cls(members.numbers, np.ascontiguousarray(shapes), n_large)

    def __len__(self) -> int:
        return len(self.shapes)

    def logarithms(self, standard_deviation: float, position: FloatArray, indices: IntArray) -> FloatArray:
        """Return the logarithm (n_members,) of each member's factor.

        Parameters
        ----------
        standard_deviation
            Of the logarithm.
        position
            (n,) standard normal coefficients of some shapes; those of all others are 0.
        indices
            (n,) of these shapes.
        """
        return standard_deviation * (position @ self.shapes[indices])

    def standard_errors(
        self, standard_deviation: float, covariance: FloatArray, indices: IntArray
    ) -> FloatArray:
        """Return the standard error (n_members,) of each logarithm.

        Parameters
        ----------
        standard_deviation
            Of the logarithm.
        covariance
            (n, n) of the coefficients of some shapes; all others are known to be 0.
        indices
            (n,) of these shapes.
        """
        shapes = self.shapes[indices]
        variance = np.einsum("pe,pq,qe->e", shapes, covariance, shapes)
        return np.asarray(standard_deviation * np.sqrt(variance))


def _bar_indices(members: MemberTable) -> IntArray:
    """Return the index (n_members,) of the bar, or the plate, of which each member is a part.

    Two members belong to the same bar if they meet at a node without a corner, and to the same plate if they
    have a node in common.
    """
    nodes = np.concatenate([np.asarray(ends, int) for ends in members.ends])
    owners = np.repeat(np.arange(len(members.ends)), [len(ends) for ends in members.ends])
    incidence = csr_array((np.ones(len(nodes)), (owners, nodes)))
    first, second = (incidence @ incidence.T).nonzero()
    continued = np.where(
        members.bars[first] & members.bars[second],
        _bends(members, first, second) < np.radians(RANDOM_FIELD.least_corner),
        ~members.bars[first] & ~members.bars[second],
    )
    edges = first[continued], second[continued]
    graph = csr_array((np.ones(len(edges[0])), edges), shape=(len(members.ends),) * 2)
    return np.asarray(connected_components(graph, directed=False)[1])


def _bends(members: MemberTable, first: IntArray, second: IntArray) -> FloatArray:
    """Return the angles, rad, between bars that have an end in common; 0 where one continues the other.

    The law of cosines in the triangle of the common end and both centres.
    """
    half = np.hypot(*(members.points[:, 1] - members.points[:, 0]).T) / 2
    a, b = half[first], half[second]
    c = np.linalg.norm(members.centres[first] - members.centres[second], axis=1)
    cosine = (c**2 - a**2 - b**2) / np.maximum(2 * a * b, SAFE_DIVISOR)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))
