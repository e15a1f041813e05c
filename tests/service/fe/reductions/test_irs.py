import numpy as np

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import reduce, reduction_of

SYSTEMS = {name: assemble(STRUCTURES[name]()) for name in ("cantilever", "chapter-5-beam", "bay")}
MASTERS = tuple(Dof(node, "Y") for node in range(3, 22, 2))


def errors(kind: str, **parameters: float) -> np.ndarray:
    """Frequency errors, relative, of the cantilever's first modes."""
    reduced, _ = reduce(SYSTEMS["cantilever"], MASTERS, reduction_of(kind, parameters)).modes()
    return np.asarray(reduced / SYSTEMS["cantilever"].modes().frequencies[: len(reduced)] - 1)


def test_it_lies_between_guyan_and_the_exact_modes() -> None:
    static, once, often = errors("guyan"), errors("irs"), errors("irs", iterations=10)
    # up to the seventh of ten modes; the last are those of the mesh of masters
    assert (once[2:7] < 0.1 * static[2:7]).all()
    assert (often[4:7] < 0.1 * once[4:7]).all()
    assert (often[:7] > -1e-7).all()  # rounding: eigenvalues span 1e8


def test_its_errors_grow_with_the_sixth_power_of_frequency() -> None:
    full = SYSTEMS["cantilever"].modes().frequencies
    error = errors("irs")[4:6]
    # followers are wrong by lambda^2, energies by its square, lambda by lambda^3 of itself
    slope = np.diff(np.log(error)) / np.diff(np.log(full[4:6] ** 2))
    np.testing.assert_allclose(slope, 3.0, rtol=0.4)  # the orders beyond, near the slaves' first mode
    static = np.diff(np.log(errors("guyan")[4:6])) / np.diff(np.log(full[4:6] ** 2))
    assert slope > 2 * static


def test_repeated_it_ends_at_the_lowest_modes() -> None:
    # Friswell, Garvey and Penny (1995): the followers converge to those of the lowest modes
    often = reduce(SYSTEMS["cantilever"], MASTERS, reduction_of("irs", {"iterations": 100}))
    exact = reduce(SYSTEMS["cantilever"], MASTERS, reduction_of("serep", {"modes": len(MASTERS)}))
    size = np.abs(exact.transformation).max()
    # the tenth mode converges by (omega_10/omega_11)^2 a step; what is left lies far below a part in 1e4
    np.testing.assert_allclose(often.transformation, exact.transformation, atol=1e-4 * size)


def test_a_free_structure_keeps_its_rigid_body_modes() -> None:
    system = SYSTEMS["bay"]
    masters = tuple(dof for dof in system.dofs if dof.direction != "RZ" and dof.node % 2)
    found, _ = reduce(system, masters, reduction_of("irs")).modes()
    assert (found[:3] < 1e-3).all()  # Hz, of 342: the root of rounding
    np.testing.assert_allclose(
        found[3:6], system.modes().frequencies[3:6], rtol=1e-3
    )  # as Guyan's error squared
