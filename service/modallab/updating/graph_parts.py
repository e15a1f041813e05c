"""Connected parts of like size of a graph, with few edges between them."""

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from modallab.core.arrays import FloatArray, IntArray
from modallab.updating.partition_settings import PARTITION


def graph_parts(graph: csr_array, count: int) -> list[IntArray]:
    """Return so many connected parts of a graph, each as its vertices, rising; at least one a component.

    Every part is cut in two where the second eigenvector of its Laplacian (Fiedler's) says, in proportion to
    the parts that each half has yet to make. Pothen, Simon and Liou (1990), SIAM Journal on Matrix Analysis
    and Applications 11, 430-452.

    Parameters
    ----------
    graph
        (n, n) symmetric, positive weights of edges.
    count
        At most n.
    """
    pieces = _components(graph, np.arange(graph.shape[0]))
    part_counts = _part_counts(np.array([len(piece) for piece in pieces]), max(count, len(pieces)))
    queue = list(zip(pieces, part_counts.tolist(), strict=True))
    parts: list[IntArray] = []
    while queue:
        piece, n_parts = queue.pop()
        if n_parts == 1:
            parts.append(np.sort(piece))
            continue
        halves = _bisection(graph, piece, (n_parts // 2) / n_parts)
        queue += zip(halves, _part_counts(np.array([len(half) for half in halves]), n_parts), strict=True)
    return sorted(parts, key=lambda part: int(part[0]))


def _part_counts(sizes: IntArray, count: int) -> IntArray:
    """Return how many parts each piece is cut into, (n,), in proportion to its size: one or more."""
    part_counts = np.ones(len(sizes), int)
    for _ in range(count - len(sizes)):
        # the piece of the largest parts is cut once more; one of single vertices cannot be
        part_counts[np.argmax(np.where(part_counts < sizes, sizes / part_counts, 0.0))] += 1
    return part_counts


def _components(graph: csr_array, vertices: IntArray) -> list[IntArray]:
    """Return the connected components of some vertices, the largest first."""
    n, label = connected_components(graph[vertices][:, vertices], directed=False)
    components = [vertices[label == i] for i in range(n)]
    return sorted(components, key=len, reverse=True)


def _bisection(graph: csr_array, piece: IntArray, share: float) -> tuple[IntArray, IntArray]:
    """Return a connected piece in two connected halves, the first of about so large a share of it."""
    subgraph = graph[piece][:, piece]
    fiedler_vector = _fiedler(subgraph)
    order = np.argsort(
        np.round(fiedler_vector / np.abs(fiedler_vector).max(), PARTITION.rounding_digits), kind="stable"
    )
    cut = _cut_position(subgraph, order, share)
    # What falls off one half hangs together with the other: the piece is connected.
    first, *fragments = _components(graph, piece[order[:cut]])
    second, *second_fragments = _components(graph, np.concatenate([piece[order[cut:]], *fragments]))
    return np.concatenate([first, *second_fragments]), second


def _cut_position(graph: csr_array, order: IntArray, share: float) -> int:
    """Return how many vertices of an order come first: about a share of them, where few edges are cut."""
    n = len(order)
    position = np.empty(n, int)
    position[order] = np.arange(n)
    edges = graph.tocoo()
    ends = position[edges.row], position[edges.col]
    # An edge is cut wherever the cut is behind its one end and before its other: each stands there twice.
    cut_weight = np.cumsum(
        np.bincount(np.minimum(*ends) + 1, edges.data, n + 1)
        - np.bincount(np.maximum(*ends) + 1, edges.data, n + 1)
    )
    target = share * n
    positions = np.arange(1, n)
    candidates = positions[
        np.abs(positions - target) <= max(PARTITION.cut_slack * min(target, n - target), 1.0)
    ]
    # of equal ones that which is nearest, the smaller of two
    return int(
        candidates[
            np.lexsort(
                (
                    np.abs(candidates - target),
                    np.round(cut_weight[candidates] / cut_weight.max(), PARTITION.rounding_digits),
                )
            )[0]
        ]
    )


def _fiedler(graph: csr_array) -> FloatArray:
    """Return the eigenvector of the lowest eigenvalue above zero of a connected graph's Laplacian, (n,)."""
    n = graph.shape[0]
    laplacian = diags_array(np.asarray(graph.sum(axis=1)).ravel()) - graph
    if n <= PARTITION.dense_vertices:
        _, vectors = eigh(laplacian.toarray(), subset_by_index=(1, 1))
        return np.asarray(vectors[:, 0])
    # Of the order of the eigenvalue itself in the worst case, a chain: pi^2 / n^2 of a weight.
    shift = float(graph.data.mean()) / n**2
    factor = splu((laplacian + shift * diags_array(np.ones(n))).tocsc(), permc_spec="MMD_AT_PLUS_A")
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(n)  # any that holds the vector; the same every time
    _, vectors = eigsh(laplacian, 2, sigma=-shift, OPinv=inverse, v0=start)
    # eigsh gives them by rising eigenvalue: behind the constant one
    return np.asarray(vectors[:, 1])
