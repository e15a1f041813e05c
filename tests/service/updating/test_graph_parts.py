"""Parts of graphs whose best cut is known."""

import numpy as np
from scipy.sparse import block_diag, csr_array, diags_array

from modallab.updating.graph_parts import graph_parts


def chain(n: int) -> csr_array:
    return csr_array(diags_array([np.ones(n - 1)] * 2, offsets=(-1, 1)))


def sizes(parts: list[np.ndarray]) -> list[int]:
    return [len(part) for part in parts]


def test_a_chain_is_cut_into_runs_however_long_it_is() -> None:
    for n in (10, 1000, 5000):  # dense, and sparse with eigenvalues down to 4e-7
        parts = graph_parts(chain(n), 5)
        assert sizes(parts) == [n // 5] * 5
        assert all((np.diff(part) == 1).all() for part in parts)


def test_two_cliques_are_parted_at_the_edge_between_them() -> None:
    clique = np.ones((6, 6)) - np.eye(6)
    graph = block_diag([clique, clique]).toarray()
    graph[5, 6] = graph[6, 5] = 1.0
    one, other = graph_parts(csr_array(graph), 2)
    assert one.tolist() == list(range(6))
    assert other.tolist() == list(range(6, 12))


def test_components_are_shared_out_by_size_and_stay_apart() -> None:
    graph = csr_array(block_diag([chain(30), chain(10), chain(1)]))
    parts = graph_parts(graph, 5)
    assert sizes(parts) == [10, 10, 10, 10, 1]
    assert len(graph_parts(graph, 1)) == 3, "a part was made of what nothing joins"


def test_a_star_keeps_its_centre_joined_to_all_of_a_part() -> None:
    # only one part can be connected over the centre: the others are single vertices
    star = np.zeros((9, 9))
    star[0, 1:] = star[1:, 0] = 1.0
    parts = graph_parts(csr_array(star), 4)
    assert sorted(sizes(parts)) == [1, 1, 1, 6]


def test_as_many_parts_as_vertices_are_one_each() -> None:
    assert [part.tolist() for part in graph_parts(chain(7), 7)] == [[i] for i in range(7)]
