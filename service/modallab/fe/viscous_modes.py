"""Modes that viscous damping couples, answering together."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SOLUTION_ROUNDING
from modallab.fe.cache import cached
from modallab.fe.settings import CACHE, DAMPED_MODES


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
        self._near = np.flatnonzero((share > DAMPED_MODES.near_coupling).any(axis=0))
        self._inverse = np.linalg.inv(self._together(self._near))
        self._apart = coupling.copy()  # between modes that are not solved for together
        self._apart[np.ix_(self._near, self._near)] = 0.0
        self._alone, self._turned = np.ascontiguousarray(1 / direct.T), -1j * omega
        self._kept: dict[str, object] = {}

    def _together(self, modes: np.ndarray) -> ComplexArray:
        """Return the dynamic stiffness of some modes, (n_freq, k, k)."""
        full = 1j * self._omega[:, None, None] * self._coupling[np.ix_(modes, modes)]
        full[:, np.arange(len(modes)), np.arange(len(modes))] += self._direct[:, modes]
        return np.asarray(full, complex)

    def receptance(self, left: FloatArray | ComplexArray, right: FloatArray | ComplexArray) -> ComplexArray:
        """Return left G right^T of modal shapes (n_left, m) and (n_right, m), (n_freq, n_left, n_right)."""
        if len(left) < len(right):  # G is symmetric
            return self.receptance(right, left).swapaxes(1, 2)
        # A column at a time, which stays in the cache; and many questions are of a force asked about before.
        found = np.array([left @ self._known_answer(force) for force in right])
        return found.transpose(2, 1, 0)

    def _known_answer(self, force: FloatArray | ComplexArray) -> ComplexArray:
        """Return the modal answers (m, n_freq) to modal forces (m,)."""
        key = (force.dtype.char, force.tobytes())
        return cached(self._kept, "answers", key, lambda: self._answer(force), CACHE.modal_forces)

    def _answer(self, force: FloatArray | ComplexArray) -> ComplexArray:
        """Return the modal answers (m, n_freq) to modal forces (m,)."""
        left: ComplexArray = np.repeat(force[:, None], len(self._omega), axis=1).astype(complex)
        answer = np.zeros_like(left)
        enough = SOLUTION_ROUNDING * float(np.abs(force).max(initial=0.0))
        for _ in range(DAMPED_MODES.max_iterations):
            step = left * self._alone
            step[self._near] = (self._inverse @ left[self._near].T[..., None])[..., 0].T
            answer += step
            # What a step answers alone or together is answered: what it does to the others is left.
            left = self._coupled(step)
            left *= self._turned
            if not float(np.abs(left).max(initial=0.0)) > enough:
                return answer
        whole = np.linalg.solve(self._together(np.arange(len(force))), np.asarray(force, complex)[:, None])
        return np.asarray(whole[..., 0].T)

    def _coupled(self, answer: ComplexArray) -> ComplexArray:
        if np.iscomplexobj(self._apart):
            return np.asarray(self._apart @ answer)
        product: ComplexArray = (self._apart @ answer.view(float)).view(complex)
        return product
