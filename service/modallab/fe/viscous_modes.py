"""Response of modes coupled by viscous damping."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SOLUTION_ROUNDING
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.settings import CACHE, DAMPED_MODES

MODAL_RESPONSES: CacheSlot[ComplexArray] = CacheSlot("modal responses", CACHE.modal_forces)


class CoupledModes:
    """Solution of (Lambda - omega^2 + i omega C) q = f with a full modal damping matrix C.

    Block Jacobi iteration: modes near the frequencies, where coupling matters, are one block; for the
    others, most of a large model, the diagonal dominates and a few iterations suffice.

    Parameters
    ----------
    direct
        (n_freq, m) diagonal of the modal dynamic stiffness.
    coupling
        (m, m) off-diagonal modal damping; its diagonal is zero.
    omega
        (n_freq,) rad/s.
    """

    def __init__(self, direct: ComplexArray, coupling: FloatArray | ComplexArray, omega: FloatArray) -> None:
        self._direct, self._coupling, self._omega = direct, coupling, omega
        share = omega[:, None] * np.abs(coupling).sum(axis=1) / np.abs(direct)
        self._near = np.flatnonzero((share > DAMPED_MODES.near_coupling).any(axis=0))
        self._inverse = np.linalg.inv(self._dynamic_stiffness(self._near))
        self._far_coupling = coupling.copy()  # coupling outside the block of near modes
        self._far_coupling[np.ix_(self._near, self._near)] = 0.0
        self._inverse_direct, self._velocity_factor = np.ascontiguousarray(1 / direct.T), -1j * omega
        self._cache = Cache()

    def _dynamic_stiffness(self, modes: np.ndarray) -> ComplexArray:
        """Return the dynamic stiffness of some modes, (n_freq, k, k)."""
        full = 1j * self._omega[:, None, None] * self._coupling[np.ix_(modes, modes)]
        full[:, np.arange(len(modes)), np.arange(len(modes))] += self._direct[:, modes]
        return np.asarray(full, complex)

    def receptance(
        self, outputs: FloatArray | ComplexArray, inputs: FloatArray | ComplexArray
    ) -> ComplexArray:
        """Return left G right^T of modal shapes (n_left, m) and (n_right, m), (n_freq, n_left, n_right)."""
        if len(outputs) < len(inputs):  # G is symmetric
            return self.receptance(inputs, outputs).swapaxes(1, 2)
        # One column at a time fits the processor's cache, and many forces recur.
        responses = np.array([outputs @ self._cached_response(force) for force in inputs])
        return responses.transpose(2, 1, 0)

    def _cached_response(self, force: FloatArray | ComplexArray) -> ComplexArray:
        """Return the modal responses (m, n_freq) to modal forces (m,)."""
        key = (force.dtype.char, force.tobytes())
        return self._cache.compute(MODAL_RESPONSES, key, lambda: self._response(force))

    def _response(self, force: FloatArray | ComplexArray) -> ComplexArray:
        """Return the modal responses (m, n_freq) to modal forces (m,)."""
        residual: ComplexArray = np.repeat(force[:, None], len(self._omega), axis=1).astype(complex)
        response = np.zeros_like(residual)
        tolerance = SOLUTION_ROUNDING * float(np.abs(force).max(initial=0.0))
        for _ in range(DAMPED_MODES.max_iterations):
            step = residual * self._inverse_direct
            step[self._near] = (self._inverse @ residual[self._near].T[..., None])[..., 0].T
            response += step
            # The blocks are solved exactly: only coupling outside the blocks remains.
            residual = self._coupled(step)
            residual *= self._velocity_factor
            if not float(np.abs(residual).max(initial=0.0)) > tolerance:
                return response
        response_of_all = np.linalg.solve(
            self._dynamic_stiffness(np.arange(len(force))), np.asarray(force, complex)[:, None]
        )
        return np.asarray(response_of_all[..., 0].T)

    def _coupled(self, answer: ComplexArray) -> ComplexArray:
        if np.iscomplexobj(self._far_coupling):
            return np.asarray(self._far_coupling @ answer)
        product: ComplexArray = (self._far_coupling @ answer.view(float)).view(complex)
        return product
