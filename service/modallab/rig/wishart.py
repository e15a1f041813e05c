"""Random draws of averaged spectra: complex Wishart distribution."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.spectrum_settings import WISHART
from modallab.rig.wishart_forces import wishart_of_several_forces


def wishart_spectra(
    spectra: CrossSpectra,
    rng: np.random.Generator,
    n_tests: int = 1,
    *,
    signal: FloatArray | ComplexArray | None = None,
) -> CrossSpectra:
    """Return random spectra with the distribution of averages of Gaussian records.

    Complex Wishart law with `spectra.averages` degrees of freedom a line, real at 0 Hz, by its
    conditional (Bartlett) form: G_ff is a Gamma variable; given it, G_fx of each channel is complex
    normal about H G_ff, and what the force does not explain a Gamma variable of one average less.
    Lines and runs are independent; the channels of a run share the measured force with its noise. Beside
    it each channel has two random parts: one from the part of the signal that the measured force does not
    explain, which is the same in all channels of the run, and one from the channel's own noise.
    Goodman (1963), Annals of Mathematical Statistics 34, 152-177.

    Parameters
    ----------
    spectra
        Expected.
    n_tests
        How often the test is repeated; the runs of a test follow one another.
    signal
        (n_run, n_freq) G_ff without its noise, N^2/Hz, of several forces (n_run, n_freq, n_in, n_in); None:
        there is no noise.

    Returns
    -------
    Spectra of `n_tests * n_run` runs.
    """
    n_run, n_freq, n_in, n_out = spectra.fx.shape
    if n_in > 1:
        return wishart_of_several_forces(spectra, rng, n_tests, signal=signal)
    ff = np.empty((n_tests, n_run, n_freq))
    fx = np.empty((n_tests, n_run, n_freq, n_out), complex)
    xx = np.empty((n_tests, n_run, n_freq, n_out))
    hidden = None if signal is None or n_out == 1 else _unmeasured_signal(spectra, signal.real)
    law = _SingleForceLaw(spectra) if hidden is None else _NoisyForceLaw(spectra, hidden)
    batch = max(1, WISHART.single_force_block // (n_run * n_freq * n_out))
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


class _SingleForceLaw:
    """Conditional distribution of the spectra of one force."""

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
        force_power = ff[..., None]
        rng.standard_normal(out=fx.view(float))
        fx.imag[:, :, self.real] = 0.0
        fx *= np.sqrt(force_power) * self.spread
        fx += self.h * force_power
        rng.standard_gamma(self.n - 1, out=xx)
        xx[:, :, self.real] = rng.standard_gamma((self.n - 1) / 2, xx[:, :, self.real].shape)
        xx *= self.residual
        xx += (fx.real**2 + fx.imag**2) / force_power


def _unmeasured_signal(spectra: CrossSpectra, signal: FloatArray) -> ComplexArray | None:
    """Return the response to the part of the signal that a noisy force channel does not explain.

    The signal has unit power; shape (n_run, n_freq, n_out). None if there are too few averages, or if the
    force channel explains the whole signal.
    """
    share = signal / spectra.ff[:, :, 0, 0].real
    if spectra.averages < WISHART.min_averages or (1 - share).max() < PRODUCT_ROUNDING:
        return None
    safe = np.where(signal > 0, signal, 1.0)
    root = np.sqrt(np.clip(1 - share, 0.0, 1.0) / safe)
    return np.asarray(np.where(signal > 0, root, 0.0)[:, :, None] * spectra.fx[:, :, 0])


class _NoisyForceLaw(_SingleForceLaw):
    """Conditional distribution with a noisy force: the unexplained signal is a second, unmeasured force."""

    def __init__(self, spectra: CrossSpectra, hidden: ComplexArray) -> None:
        super().__init__(spectra)
        squares = np.where(spectra.freq == 0, self.n / 2, self.n)[:, None]
        self.hidden = hidden / np.sqrt(squares)
        independent_power = self.residual - (self.hidden.real**2 + self.hidden.imag**2)
        self.residual = np.maximum(independent_power, 0.0)
        self.spread = np.sqrt(self.residual / 2)

    def fill(self, rng: np.random.Generator, ff: FloatArray, fx: ComplexArray, xx: FloatArray) -> None:
        """Draw into arrays (n_tests, n_run, n_freq[, n_out])."""
        ff[:] = self.force * self._squares(rng, ff.shape, self.n)
        force_power = ff[..., None]
        common_draw = np.sqrt(0.5) * self._normal(rng, force_power.shape)
        explained = np.sqrt(force_power) * (
            self.hidden * common_draw + self.spread * self._normal(rng, fx.shape)
        )
        fx[:] = self.h * force_power + explained
        residual_draw = np.sqrt(self._squares(rng, force_power.shape, self.n - 1)) * self.hidden
        residual_draw = residual_draw + self.spread * self._normal(rng, fx.shape)
        xx[:] = self.residual * self._squares(rng, xx.shape, self.n - 2)
        xx += residual_draw.real**2 + residual_draw.imag**2
        xx += (fx.real**2 + fx.imag**2) / force_power

    def _squares(self, rng: np.random.Generator, shape: tuple[int, ...], n: float) -> FloatArray:
        """Return Gamma variables of n averages; of half as many at 0 Hz."""
        gamma_draw = rng.standard_gamma(n, shape)
        gamma_draw[:, :, self.real] = rng.standard_gamma(n / 2, gamma_draw[:, :, self.real].shape)
        return gamma_draw

    def _normal(self, rng: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
        """Return complex normal numbers, real at 0 Hz."""
        normal_draw = rng.standard_normal((*shape, 2)).view(complex)[..., 0]
        normal_draw.imag[:, :, self.real] = 0.0
        return normal_draw
