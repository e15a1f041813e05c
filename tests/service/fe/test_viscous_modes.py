import numpy as np
import pytest

from modallab.fe.viscous_modes import CoupledModes

OMEGA = 2 * np.pi * np.linspace(1.0, 100.0, 60)


def modes(loss: float, *, count: int = 40) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return direct stiffnesses, couplings and shapes of modes from 5 to 800 Hz, two of them close."""
    rng = np.random.default_rng(0)
    natural = 2 * np.pi * np.geomspace(5.0, 800.0, count)
    natural[8] = natural[7] * 1.001
    spread = rng.standard_normal((count, count)) * np.sqrt(np.outer(natural, natural))
    damping = loss * (spread + spread.T) / 2
    own = loss * natural + 1.0
    direct = natural**2 - OMEGA[:, None] ** 2 + 1j * OMEGA[:, None] * own
    return direct, damping - np.diag(np.diag(damping)), rng.standard_normal((5, count))


@pytest.mark.parametrize("loss", [1e-4, 1e-2, 0.3], ids=["light", "usual", "so strong that all are coupled"])
def test_modes_answer_as_if_all_were_solved_for_together(loss: float) -> None:
    direct, coupling, shapes = modes(loss)
    whole = 1j * OMEGA[:, None, None] * coupling + direct[:, :, None] * np.eye(direct.shape[1])
    expected = shapes @ np.linalg.inv(whole) @ shapes[:2].T
    found = CoupledModes(direct, coupling, OMEGA).receptance(shapes, shapes[:2])
    # A force left over of 1e-11 moves a mode, at its resonance, by 1e-11 over its loss of 1e-4 or more.
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_either_side_may_be_the_longer_one() -> None:
    direct, coupling, shapes = modes(1e-2)
    coupled = CoupledModes(direct, coupling, OMEGA)
    one, other = coupled.receptance(shapes[:1], shapes), coupled.receptance(shapes, shapes[:1])
    np.testing.assert_allclose(one, other.swapaxes(1, 2), rtol=1e-12)
