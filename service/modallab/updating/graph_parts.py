"""Recursive spectral bisection of a graph into connected parts of similar size."""

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from modallab.core.arrays import FloatArray, IntArray
from modallab.updating.partition_settings import PARTITION


def graph_parts(graph: csr_array, count: int) -> list[IntArray]:
    """Return connected parts of a graph, each as its vertices in rising order; at least one a component.

    Every part is bisected by the second eigenvector of its Laplacian (Fiedler vector), in proportion to the
    number of parts that each half has yet to give. Pothen, Simon and Liou (1990), SIAM Journal on Matrix
    Analysis and Applications 11, 430-452.

    Parameters
    ----------
    graph
        (n, n) symmetric, positive weights of edges.
    count
        Number of parts, at most n.
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
    """Return the number of parts of each piece (n,), in proportion to its size, at least one."""
    part_counts = np.ones(len(sizes), int)
    for _ in range(count - len(sizes)):
        # the piece with the largest parts is cut once more; single vertices cannot be
        part_counts[np.argmax(np.where(part_counts < sizes, sizes / part_counts, 0.0))] += 1
    return part_counts


def _components(graph: csr_array, vertices: IntArray) -> list[IntArray]:
    """Return the connected components of some vertices, the largest first."""
    n, label = connected_components(graph[vertices][:, vertices], directed=False)
    components = [vertices[label == i] for i in range(n)]
    return sorted(components, key=len, reverse=True)


def _bisection(graph: csr_array, piece: IntArray, share: float) -> tuple[IntArray, IntArray]:
    """Return two connected halves of a connected piece, the first of about a given share."""
    subgraph = graph[piece][:, piece]
    fiedler_vector = _fiedler(subgraph)
    order = np.argsort(
        np.round(fiedler_vector / np.abs(fiedler_vector).max(), PARTITION.rounding_digits), kind="stable"
    )
    cut = _cut_position(subgraph, order, share)
    # Fragments of one half are connected with the other half, as the piece is connected.
    first, *fragments = _components(graph, piece[order[:cut]])
    second, *second_fragments = _components(graph, np.concatenate([piece[order[cut:]], *fragments]))
    return np.concatenate([first, *second_fragments]), second


def _cut_position(graph: csr_array, order: IntArray, share: float) -> int:
    """Return the number of leading vertices of an order at the cheapest cut near a given share."""
    n = len(order)
    position = np.empty(n, int)
    position[order] = np.arange(n)
    edges = graph.tocoo()
    ends = position[edges.row], position[edges.col]
    # An edge is cut at every position between its ends; the symmetric matrix counts each edge twice.
    cut_weight = np.cumsum(
        np.bincount(np.minimum(*ends) + 1, edges.data, n + 1)
        - np.bincount(np.maximum(*ends) + 1, edges.data, n + 1)
    )
    target = share * n
    positions = np.arange(1, n)
    candidates = positions[
        np.abs(positions - target) <= max(PARTITION.cut_slack * min(target, n - target), 1.0)
    ]
    # among equal weights the position nearest to the target, then the smaller one
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
    """Return the Fiedler vector of a connected graph (n,): eigenvector of the second Laplacian eigenvalue."""
    n = graph.shape[0]
    laplacian = diags_array(np.asarray(graph.sum(axis=1)).ravel()) - graph
    if n <= PARTITION.dense_vertices:
        _, vectors = eigh(laplacian.toarray(), subset_by_index=(1, 1))
        return np.asarray(vectors[:, 0])
    # In the worst case, a chain, of the order of the eigenvalue: pi^2 / n^2 of a weight.
    shift = float(graph.data.mean()) / n**2
    factor = splu((laplacian + shift * diags_array(np.ones(n))).tocsc(), permc_spec="MMD_AT_PLUS_A")
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(n)  # a fixed start vector, so that results repeat
    _, vectors = eigsh(laplacian, 2, sigma=-shift, OPinv=inverse, v0=start)
    # by rising eigenvalue: the constant vector first
    return np.asarray(vectors[:, 1])
