"""Random draws of averaged spectra under deterministic excitation: noncentral complex Wishart."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.periodic import PeriodicSignal


def noncentral_wishart_spectra(
    spectra: CrossSpectra,
    clean: ComplexArray,
    force_noise: FloatArray,
    signals: Sequence[PeriodicSignal],
    rng: np.random.Generator,
) -> CrossSpectra:
    """Return random spectra with a deterministic signal in every average.

    Noncentral complex Wishart distribution. The deterministic part of n averages is W m, with W the (n, k)
    weights of k signals m. By the QR decomposition W = Q R, a rotation among the averages moves it into the
    first k, as R m; the others hold noise alone, and Gaussian noise is invariant to rotation. Without noise
    the coherence of an identical signal in every record is 1, and G_ff is exact.
    James (1964), Annals of Mathematical Statistics 35, 475-501.

    Parameters
    ----------
    spectra
        Expected, with one force a run.
    clean
        (n_run, n_freq, 1 + 2 n_out) G_ff, G_fx and G_xx as they are without noise and converter.
    force_noise
        (n_run,) N^2/Hz, in G_ff.
    signals
        Deterministic signals of each run.
    """
    n, runs = round(spectra.averages), []
    for run, signal in enumerate(signals):
        gain = gain_of(spectra, clean[run], force_noise[run], run)
        random_part = _RandomPart.of(spectra, run, signal.expected(gain))
        rotated = np.linalg.qr(signal.weights(n, rng), mode="r")
        rotated_averages = np.tensordot(rotated, signal.signals * gain, axes=1) + random_part.averages(
            len(rotated), rng
        )
        force_conjugate, response = rotated_averages[..., :1].conj(), rotated_averages[..., 1:]
        sums = (
            (force_conjugate * force_conjugate.conj()).sum(axis=0),
            (force_conjugate * response).sum(axis=0),
            _squares(response).sum(axis=0),
        )
        runs.append([(a + b) / n for a, b in zip(sums, random_part.sums(n - len(rotated), rng), strict=True)])
    ff, fx, xx = (np.array(part) for part in zip(*runs, strict=True))
    return CrossSpectra(spectra.freq, ff[..., None], fx[:, :, None], xx.real, spectra.averages)


def gain_of(spectra: CrossSpectra, clean: ComplexArray, force_noise: float, run: int) -> ComplexArray:
    """Return the gain of the converter on each channel, (n_freq, 1 + n_out)."""
    n_out = spectra.xx.shape[2]
    ff, fx = clean[:, 0].real, clean[:, 1 : 1 + n_out]
    force = np.sqrt(np.clip((spectra.ff[run, :, 0, 0].real - force_noise) / ff, 0.0, 1.0))
    response_gain = np.divide(spectra.fx[run, :, 0], fx, out=np.ones_like(fx), where=fx != 0)
    response = response_gain / np.where(force > 0, force, 1.0)[:, None]
    return np.concatenate([force[:, None], response], axis=1)


def signal_of(
    spectra: CrossSpectra, clean: ComplexArray, force_noise: FloatArray
) -> FloatArray | ComplexArray:
    """Return G_ff without its noise, (n_run, n_freq), of several forces (n_run, n_freq, n_in, n_in).

    Parameters
    ----------
    clean, force_noise
        As of `noncentral_wishart_spectra`.
    """
    if (n_in := spectra.ff.shape[2]) > 1:
        return clean[..., : n_in**2].reshape(spectra.ff.shape)
    gains = [gain_of(spectra, clean[run], noise, run)[:, 0] for run, noise in enumerate(force_noise)]
    return np.asarray(np.abs(gains) ** 2 * clean[:, :, 0].real)


def _squares(values: ComplexArray) -> FloatArray:
    return values.real**2 + values.imag**2


@dataclass(frozen=True, eq=False)
class _RandomPart:
    """Random part of a run's signals: its expected spectra in Bartlett's decomposition."""

    force: FloatArray
    """(n_freq, 1) N^2/Hz, force spectrum."""
    h: ComplexArray
    """(n_freq, n_out) response per unit force."""
    response: FloatArray
    """(n_freq, n_out) response spectrum not coherent with the force."""
    real: FloatArray
    """(n_freq, 1) 2 where transforms are real, half as many squares an average; else 1."""

    @classmethod
    def of(cls, spectra: CrossSpectra, run: int, periodic_spectra: ComplexArray) -> "_RandomPart":
        """Return the random part: a run's spectra minus those of its deterministic signals."""
        n_out = spectra.xx.shape[2]
        total_spectra = np.concatenate(
            [spectra.ff[run, :, 0], spectra.fx[run, :, 0], spectra.xx[run]], axis=1
        )
        random_spectra = np.where(
            np.abs(total_spectra - periodic_spectra) > PRODUCT_ROUNDING * np.abs(total_spectra),
            total_spectra - periodic_spectra,
            0.0,
        )
        force = random_spectra[:, :1].real.clip(min=0.0)
        safe = np.where(force > 0, force, 1.0)
        h: ComplexArray = np.asarray(
            np.where(force > 0, random_spectra[:, 1 : 1 + n_out], 0.0) / safe, complex
        )
        response = (random_spectra[:, 1 + n_out :].real - _squares(h) * force).clip(min=0.0)
        return cls(force, h, response, np.where(spectra.freq == 0, 2.0, 1.0)[:, None])

    def averages(self, n: int, rng: np.random.Generator) -> ComplexArray:
        """Return n averages of all channels, (n, n_freq, 1 + n_out)."""
        force = np.sqrt(self.force) * self._normal(rng, (n, *self.force.shape))
        response = np.sqrt(self.response) * self._normal(rng, (n, *self.response.shape))
        return np.concatenate([force, self.h * force + response], axis=2)

    def sums(self, n: int, rng: np.random.Generator) -> tuple[FloatArray, ComplexArray, FloatArray]:
        """Return G_ff (n_freq, 1), G_fx and G_xx (n_freq, n_out), summed over n averages."""
        if n == 0:
            return np.zeros(self.force.shape), np.zeros(self.h.shape, complex), np.zeros(self.h.shape)
        root = np.sqrt(self.force * self.real * rng.standard_gamma(n / self.real, self.force.shape))
        response = self.h * root + np.sqrt(self.response) * self._normal(rng, self.response.shape)
        incoherent = self.response * self.real * rng.standard_gamma((n - 1) / self.real, self.response.shape)
        return root**2, root * response, _squares(response) + incoherent

    def _normal(self, rng: np.random.Generator, shape: tuple[int, ...]) -> ComplexArray:
        """Return complex normal numbers of unit mean square, real where transforms are."""
        normal_draw = rng.standard_normal((*shape, 2)).view(complex)[..., 0]
        return np.where(self.real == 2, normal_draw.real, normal_draw / np.sqrt(2))
