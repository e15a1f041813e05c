"""Connected parts of like size of a graph, with few edges between them."""

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from modallab.core.arrays import FloatArray, IntArray

SLACK = 0.05  # share of the smaller half by which a cut may move to where it cuts less; or one vertex
SMALL = 250  # vertices up to which a dense eigen-solution is the faster one
ROUNDING = 10  # digits that order vertices: symmetric graphs have ties, which rounding must not part


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
    shares = _shares(np.array([len(piece) for piece in pieces]), max(count, len(pieces)))
    waiting = list(zip(pieces, shares.tolist(), strict=True))
    done: list[IntArray] = []
    while waiting:
        piece, wanted = waiting.pop()
        if wanted == 1:
            done.append(np.sort(piece))
            continue
        halves = _halves(graph, piece, (wanted // 2) / wanted)
        waiting += zip(halves, _shares(np.array([len(half) for half in halves]), wanted), strict=True)
    return sorted(done, key=lambda part: int(part[0]))


def _shares(sizes: IntArray, count: int) -> IntArray:
    """Return how many parts each piece is cut into, (n,), in proportion to its size: one or more."""
    shares = np.ones(len(sizes), int)
    for _ in range(count - len(sizes)):
        # the piece of the largest parts is cut once more; one of single vertices cannot be
        shares[np.argmax(np.where(shares < sizes, sizes / shares, 0.0))] += 1
    return shares


def _components(graph: csr_array, of: IntArray) -> list[IntArray]:
    """Return the connected components of some vertices, the largest first."""
    n, label = connected_components(graph[of][:, of], directed=False)
    found = [of[label == i] for i in range(n)]
    return sorted(found, key=len, reverse=True)


def _halves(graph: csr_array, piece: IntArray, share: float) -> tuple[IntArray, IntArray]:
    """Return a connected piece in two connected halves, the first of about so large a share of it."""
    inner = graph[piece][:, piece]
    along = _fiedler(inner)
    order = np.argsort(np.round(along / np.abs(along).max(), ROUNDING), kind="stable")
    cut = _cut(inner, order, share)
    # What falls off one half hangs together with the other: the piece is connected.
    first, *loose = _components(graph, piece[order[:cut]])
    second, *back = _components(graph, np.concatenate([piece[order[cut:]], *loose]))
    return np.concatenate([first, *back]), second


def _cut(graph: csr_array, order: IntArray, share: float) -> int:
    """Return how many vertices of an order come first: about a share of them, where few edges are cut."""
    n = len(order)
    place = np.empty(n, int)
    place[order] = np.arange(n)
    edges = graph.tocoo()
    ends = place[edges.row], place[edges.col]
    # An edge is cut wherever the cut is behind its one end and before its other: each stands there twice.
    cut = np.cumsum(
        np.bincount(np.minimum(*ends) + 1, edges.data, n + 1)
        - np.bincount(np.maximum(*ends) + 1, edges.data, n + 1)
    )
    wanted = share * n
    places = np.arange(1, n)
    near = places[np.abs(places - wanted) <= max(SLACK * min(wanted, n - wanted), 1.0)]
    # of equal ones that which is nearest, the smaller of two
    return int(near[np.lexsort((np.abs(near - wanted), np.round(cut[near] / cut.max(), ROUNDING)))[0]])


def _fiedler(graph: csr_array) -> FloatArray:
    """Return the eigenvector of the lowest eigenvalue above zero of a connected graph's Laplacian, (n,)."""
    n = graph.shape[0]
    laplacian = diags_array(np.asarray(graph.sum(axis=1)).ravel()) - graph
    if n <= SMALL:
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
