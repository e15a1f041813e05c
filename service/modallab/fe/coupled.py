"""Modes that viscous damping couples, answering together."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray

CLOSE = 0.1  # coupling over a mode's own dynamic stiffness above which modes are solved for together
EXACT = 1e-11  # of the modal force, that a solution leaves of it
ROUNDS = 40  # of corrections at most


class CoupledModes:
    """Answers of (Lambda - omega^2 + i omega C)^-1 with a full modal damping matrix C.

    Modes near enough to the frequencies for coupling to matter are solved for together; of the others, in
    a large model most, the own dynamic stiffness is so much larger that corrections by it converge in a
    few rounds (block Jacobi iteration).

    Parameters
    ----------
    direct
        (n_freq, m) dynamic stiffness of each mode by itself.
    coupling
        (m, m) what damps one mode by another's velocity, nothing on the diagonal.
    omega
        (n_freq,) rad/s.
    """

    def __init__(self, direct: ComplexArray, coupling: FloatArray | ComplexArray, omega: FloatArray) -> None:
        self._direct, self._coupling, self._omega = direct, coupling, omega
        share = omega[:, None] * np.abs(coupling).sum(axis=1) / np.abs(direct)
        self._near = np.flatnonzero((share > CLOSE).any(axis=0))
        self._far = np.setdiff1d(np.arange(direct.shape[1]), self._near)
        self._inverse = np.linalg.inv(self._together(self._near))

    def _together(self, modes: np.ndarray) -> ComplexArray:
        """Return the dynamic stiffness of some modes, (n_freq, k, k)."""
        full = 1j * self._omega[:, None, None] * self._coupling[np.ix_(modes, modes)]
        full[:, np.arange(len(modes)), np.arange(len(modes))] += self._direct[:, modes]
        return np.asarray(full, complex)

    def receptance(self, left: FloatArray | ComplexArray, right: FloatArray | ComplexArray) -> ComplexArray:
        """Return left G right^T of modal shapes (n_left, m) and (n_right, m), (n_freq, n_left, n_right)."""
        if len(left) < len(right):  # G is symmetric
            return self.receptance(right, left).swapaxes(1, 2)
        answer = self._answer(right.T)
        found = (left @ answer.reshape(len(answer), -1)).reshape(len(left), *answer.shape[1:])
        return np.asarray(found.swapaxes(0, 1))

    def _answer(self, force: FloatArray | ComplexArray) -> ComplexArray:
        """Return the modal answers (m, n_freq, k) to modal forces (m, k)."""
        direct = self._direct.T[:, :, None]
        answer = np.zeros((len(force), len(self._omega), force.shape[1]), complex)
        left = np.broadcast_to(force[:, None, :], answer.shape)
        enough = EXACT * float(np.abs(force).max(initial=0.0))
        for _ in range(ROUNDS):
            answer[self._far] += left[self._far] / direct[self._far]
            near = self._inverse @ left[self._near].swapaxes(0, 1)
            answer[self._near] += near.swapaxes(0, 1)
            left = force[:, None, :] - direct * answer - 1j * self._omega[:, None] * self._coupled(answer)
            if not float(np.abs(left).max(initial=0.0)) > enough:
                return answer
        every = np.arange(len(force))
        whole = np.linalg.solve(self._together(every), np.asarray(force, complex))
        return np.asarray(whole.swapaxes(0, 1))

    def _coupled(self, answer: ComplexArray) -> ComplexArray:
        flat = answer.reshape(len(answer), -1)
        if np.iscomplexobj(self._coupling):
            return np.asarray(self._coupling @ flat).reshape(answer.shape)
        product: ComplexArray = (self._coupling @ flat.view(float)).view(complex)
        return product.reshape(answer.shape)
