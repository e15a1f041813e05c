"""Route a with noise: averaged spectra drawn from the law they follow around the expected ones."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.drawn_forces import drawn_of_several

IN_CACHE = 2**14  # spectral values drawn at once: larger batches run at the speed of memory


def drawn_spectra(spectra: CrossSpectra, rng: np.random.Generator, n_tests: int = 1) -> CrossSpectra:
    """Return spectra as averages of Gaussian records scatter about the expected ones.

    Complex Wishart law with `spectra.averages` degrees of freedom a line, real at 0 Hz, by its
    conditional (Bartlett) form: G_ff is a Gamma variable; given it, G_fx of each channel is complex
    normal about H G_ff, and what the force does not explain a Gamma variable of one average less.
    Lines and runs are independent; the channels of a run share the force and are independent given it.
    Goodman (1963), Annals of Mathematical Statistics 34, 152-177.

    Parameters
    ----------
    spectra
        Expected.
    n_tests
        How often the test is repeated; the runs of a test follow one another.

    Returns
    -------
    Spectra of `n_tests * n_run` runs.
    """
    n_run, n_freq, n_in, n_out = spectra.fx.shape
    if n_in > 1:
        return drawn_of_several(spectra, rng, n_tests)
    ff = np.empty((n_tests, n_run, n_freq))
    fx = np.empty((n_tests, n_run, n_freq, n_out), complex)
    xx = np.empty((n_tests, n_run, n_freq, n_out))
    law = _Law(spectra)
    batch = max(1, IN_CACHE // (n_run * n_freq * n_out))
    for start in range(0, n_tests, batch):
        part = slice(start, start + batch)
        law.fill(rng, ff[part], fx[part], xx[part])
    shape = (n_tests * n_run, n_freq)
    return CrossSpectra(
        spectra.freq,
        ff.reshape(*shape, 1, 1).astype(complex),
        fx.reshape(*shape, 1, n_out),
        xx.reshape(*shape, n_out),
        spectra.averages,
    )


class _Law:
    """What the draws of all tests share."""

    def __init__(self, spectra: CrossSpectra) -> None:
        self.n = spectra.averages
        # At 0 Hz the transform of a record is real: half as many independent squares an average.
        self.real = np.flatnonzero(spectra.freq == 0)
        squares = np.where(spectra.freq == 0, self.n / 2, self.n)
        force = spectra.ff[:, :, 0, 0].real
        self.h = spectra.fx[:, :, 0, :] / force[:, :, None]
        unexplained = spectra.xx - (self.h.real**2 + self.h.imag**2) * force[:, :, None]
        self.force = force / squares
        self.residual = np.maximum(unexplained, 0.0) / squares[:, None]
        self.spread = np.sqrt(self.residual / 2)

    def fill(self, rng: np.random.Generator, ff: FloatArray, fx: ComplexArray, xx: FloatArray) -> None:
        """Draw into arrays (n_tests, n_run, n_freq[, n_out])."""
        rng.standard_gamma(self.n, out=ff)
        ff[..., self.real] = rng.standard_gamma(self.n / 2, ff[..., self.real].shape)
        ff *= self.force
        given = ff[..., None]
        rng.standard_normal(out=fx.view(float))
        fx.imag[:, :, self.real] = 0.0
        fx *= np.sqrt(given) * self.spread
        fx += self.h * given
        rng.standard_gamma(self.n - 1, out=xx)
        xx[:, :, self.real] = rng.standard_gamma((self.n - 1) / 2, xx[:, :, self.real].shape)
        xx *= self.residual
        xx += (fx.real**2 + fx.imag**2) / given
