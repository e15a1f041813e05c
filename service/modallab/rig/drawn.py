"""Route a with noise: averaged spectra drawn from the law they follow around the expected ones."""

import numpy as np

from modallab.estimation.spectra import CrossSpectra

IN_CACHE = 2**13  # spectral values drawn at once: larger batches run at the speed of memory


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
        Expected, with one force a run.
    n_tests
        How often the test is repeated; the runs of a test follow one another.

    Returns
    -------
    Spectra of `n_tests * n_run` runs.
    """
    n_run, n_freq, _, n_out = spectra.fx.shape
    force = spectra.ff[:, :, 0, 0].real
    h = spectra.fx[:, :, 0, :] / force[:, :, None]
    unexplained = np.maximum(spectra.xx - (h.real**2 + h.imag**2) * force[:, :, None], 0.0)
    # At 0 Hz the transform of a record is real: half as many independent squares an average.
    real = spectra.freq == 0
    squares = np.where(real, spectra.averages / 2, spectra.averages)
    fewer = np.where(real, (spectra.averages - 1) / 2, spectra.averages - 1)[:, None]
    unexplained /= squares[:, None]
    spread = np.sqrt(unexplained / 2)
    ff = np.empty((n_tests, n_run, n_freq))
    fx = np.empty((n_tests, n_run, n_freq, n_out), complex)
    xx = np.empty((n_tests, n_run, n_freq, n_out))
    batch = max(1, IN_CACHE // (n_run * n_freq * n_out))
    for start in range(0, n_tests, batch):
        a, c, x = (g[start : start + batch] for g in (ff, fx, xx))
        a[:] = rng.standard_gamma(squares, a.shape)
        a *= force / squares
        given = a[..., None]
        rng.standard_normal(out=c.view(float))
        c[:, :, real].imag = 0.0
        c *= np.sqrt(given) * spread
        c += h * given
        x[:] = rng.standard_gamma(fewer, x.shape)
        x *= unexplained
        x += (c.real**2 + c.imag**2) / given
    shape = (n_tests * n_run, n_freq)
    return CrossSpectra(
        spectra.freq,
        ff.reshape(*shape, 1, 1),
        fx.reshape(*shape, 1, n_out),
        xx.reshape(*shape, n_out),
        spectra.averages,
    )
