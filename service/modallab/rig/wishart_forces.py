"""Random draws of averaged spectra of several forces: complex Wishart distribution."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.estimation.condition import independent_condition
from modallab.estimation.partial_coherence import regular_coherence
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.spectrum_settings import WISHART
from modallab.rig.triangular_products import (
    add_adjoint_product,
    product_of_triangles,
    triangular_product,
    triangular_square,
)


def wishart_of_several_forces(
    spectra: CrossSpectra,
    rng: np.random.Generator,
    n_tests: int,
    *,
    signal: FloatArray | ComplexArray | None = None,
) -> CrossSpectra:
    """Return random spectra of several forces with the distribution of averages of Gaussian records.

    Complex Wishart law, real at 0 Hz, by Bartlett's factors: with the Cholesky factor L of the expected
    G_ff, the drawn one is L A A^H L^H / n, A lower triangular, the squares of its diagonal Gamma(n - i), what
    is below it complex normal. Given G_ff, G_fx of each channel is complex normal about G_ff H^T, and what
    the forces do not explain a Gamma variable of as many averages less as there are forces. The part of the
    signals that the measured, noisy forces do not explain is the same random part in all channels of a run.
    Goodman (1963), Annals of Mathematical Statistics 34, 152-177.

    Parameters
    ----------
    spectra
        Expected, of no fewer averages than forces.
    n_tests
        How often the test is repeated; the runs of a test follow one another.
    signal
        (n_run, n_freq, n_in, n_in) G_ff without its noise, N^2/Hz; None: there is none.

    Raises
    ------
    InvalidInputError
        If the forces are not independent of each other.
    """
    n_run, n_freq, n_in, n_out = spectra.fx.shape
    hidden = (
        None if signal is None or n_out == 1 else _unmeasured_signals(spectra, np.asarray(signal, complex))
    )
    law = _MultipleForceLaw(spectra) if hidden is None else _NoisyForcesLaw(spectra, hidden)
    ff = np.empty((n_tests, n_run, n_freq, n_in, n_in), complex)
    fx = np.empty((n_tests, n_run, n_freq, n_in, n_out), complex)
    xx = np.empty((n_tests, n_run, n_freq, n_out))
    batch = max(1, WISHART.multiple_force_block // (n_run * n_freq * n_in * n_out))
    for start in range(0, n_tests, batch):
        part = slice(start, start + batch)
        law.fill(rng, ff[part], fx[part], xx[part])
    shape = (n_tests * n_run, n_freq)
    return CrossSpectra(
        spectra.freq,
        ff.reshape(*shape, n_in, n_in),
        fx.reshape(*shape, n_in, n_out),
        xx.reshape(*shape, n_out),
        spectra.averages,
    )


class _MultipleForceLaw:
    """Conditional distribution of the spectra of several forces."""

    def __init__(self, spectra: CrossSpectra) -> None:
        self.n, self.n_in = spectra.averages, spectra.ff.shape[-1]
        # At 0 Hz the transform of a record is real: half as many independent squares an average.
        self.real = np.flatnonzero(spectra.freq == 0)
        squares = np.where(spectra.freq == 0, self.n / 2, self.n)[:, None]
        independent_condition(spectra)
        self.root = np.linalg.cholesky(spectra.ff) / np.sqrt(self.n)
        self.h: ComplexArray = np.asarray(np.linalg.solve(spectra.ff, spectra.fx), complex)
        unexplained = spectra.xx - (spectra.fx.conj() * self.h).sum(axis=2).real
        self.residual = np.maximum(unexplained, 0.0) / squares
        self.spread = np.sqrt(self.residual / 2)[:, :, None]

    def fill(self, rng: np.random.Generator, ff: ComplexArray, fx: ComplexArray, xx: FloatArray) -> None:
        """Draw into arrays (n_tests, n_run, n_freq, n_in, n_in or n_out)."""
        root = product_of_triangles(self.root, self._factor(rng, ff))
        triangular_square(root, out=ff)
        explained = np.empty_like(fx)  # of each channel, by forces of unit density that nothing ties
        parts = explained.view(float)
        rng.standard_normal(out=parts)
        explained.imag[:, :, self.real] = 0.0
        explained *= self.spread
        add_adjoint_product(root, self.h, out=explained)
        triangular_product(root, explained, out=fx)
        rng.standard_gamma(self.n - self.n_in, out=xx)
        xx[:, :, self.real] = rng.standard_gamma((self.n - self.n_in) / 2, xx[:, :, self.real].shape)
        xx *= self.residual
        power = np.einsum("...io,...io->...o", parts, parts)
        xx += power[..., ::2]
        xx += power[..., 1::2]

    def _factor(self, rng: np.random.Generator, like: ComplexArray, n: float | None = None) -> ComplexArray:
        """Return Bartlett's factor A for every line, shaped as G_ff, of n averages; None: all."""
        n = self.n if n is None else n
        factor = np.zeros_like(like)
        row, column = np.tril_indices(self.n_in, -1)
        lines = like.shape[:-2]
        for i in range(self.n_in):  # variables of one shape are drawn three times faster than of several
            squares = rng.standard_gamma(n - i, lines)
            squares[:, :, self.real] = 2 * rng.standard_gamma((n - i) / 2, squares[:, :, self.real].shape)
            factor[..., i, i] = np.sqrt(squares)
        ties = rng.standard_normal((*lines, len(row), 2)).view(complex)[..., 0] / np.sqrt(2)
        ties[:, :, self.real] = np.sqrt(2) * ties[:, :, self.real].real
        factor[..., row, column] = ties
        return factor


def _unmeasured_signals(spectra: CrossSpectra, signal: ComplexArray) -> ComplexArray | None:
    """Return the responses to the part of the signals that noisy force channels do not explain.

    To as many independent signals of unit power as there are forces, (n_run, n_freq, n_in, n_out). Their
    part has the covariance S - S G_ff^-1 S, S the signals' spectra. For few averages, where there is nothing
    of it to draw, None.
    """
    n_in = spectra.ff.shape[2]
    _, size, regular = regular_coherence(signal)
    powered = (size > 0).all(axis=2) & regular
    safe = np.where(powered[..., None, None], signal, np.eye(n_in))
    covariance = safe - safe @ np.linalg.solve(spectra.ff, safe)
    size, vectors = np.linalg.eigh((covariance + covariance.conj().swapaxes(2, 3)) / 2)
    share = size.max(axis=2) / np.trace(safe, axis1=2, axis2=3).real
    if spectra.averages < n_in * WISHART.min_averages or share[powered].max(initial=0.0) < PRODUCT_ROUNDING:
        return None
    root = vectors * np.sqrt(np.maximum(size, 0.0))[..., None, :]
    hidden = root.conj().swapaxes(2, 3) @ np.linalg.solve(safe, spectra.fx)
    return np.asarray(np.where(powered[..., None, None], hidden, 0.0))


class _NoisyForcesLaw(_MultipleForceLaw):
    """Conditional distribution with noisy forces: unexplained signals are further, unmeasured forces."""

    def __init__(self, spectra: CrossSpectra, hidden: ComplexArray) -> None:
        super().__init__(spectra)
        squares = np.where(spectra.freq == 0, self.n / 2, self.n)[:, None]
        independent = self.residual - (np.abs(hidden) ** 2).sum(axis=2) / squares
        self.residual = np.maximum(independent, 0.0)
        self.spread = np.sqrt(self.residual / 2)[:, :, None]
        self.hidden = hidden / np.sqrt(squares)[..., None]

    def fill(self, rng: np.random.Generator, ff: ComplexArray, fx: ComplexArray, xx: FloatArray) -> None:
        """Draw into arrays (n_tests, n_run, n_freq, n_in, n_in or n_out)."""
        root = product_of_triangles(self.root, self._factor(rng, ff))
        triangular_square(root, out=ff)
        common_draw = np.sqrt(0.5) * self._normal(rng, ff.shape)
        explained = common_draw @ self.hidden + self.spread * self._normal(rng, fx.shape)
        add_adjoint_product(root, self.h, out=explained)
        triangular_product(root, explained, out=fx)
        # What is left is a test of as many averages less, of the unmeasured forces alone.
        factor = self._factor(rng, ff, self.n - self.n_in).conj().swapaxes(-1, -2)
        unexplained = factor @ self.hidden + self.spread * self._normal(rng, fx.shape)
        n_free = self.n - 2 * self.n_in
        xx[:] = rng.standard_gamma(n_free, xx.shape)
        xx[:, :, self.real] = rng.standard_gamma(n_free / 2, xx[:, :, self.real].shape)
        xx *= self.residual
        xx += (np.abs(explained) ** 2).sum(axis=-2) + (np.abs(unexplained) ** 2).sum(axis=-2)

    def _normal(self, rng: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
        """Return complex numbers with normal parts of unit variance, real at 0 Hz."""
        normal_draw = rng.standard_normal((*shape, 2)).view(complex)[..., 0]
        normal_draw.imag[:, :, self.real] = 0.0
        return normal_draw
