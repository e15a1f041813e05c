"""FRFs that extraction is judged by: a close pair of modes with noise, and a hammer that hardly excites."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet

FREQUENCIES = np.array([30.0, 42.0, 43.0, 70.0, 95.0, 110.0, 260.0])  # Hz, the last out of the band
DAMPING_RATIOS = np.array([0.5, 1.0, 1.2, 0.3, 2.0, 0.8, 1.0]) / 100
PAIR = (1, 2)  # of them, 1 Hz apart: one half-power bandwidth
N_IN_BAND = 6
N_FRF = 12


@dataclass(frozen=True, eq=False)
class Synthetic:
    """Receptances of seven modes at 12 points, the first of which is driven."""

    freq: FloatArray  # (n_freq,) Hz
    exact: ComplexArray  # (n_freq, 12) m/N
    noisy: ComplexArray  # (n_freq, 12) m/N
    variance: FloatArray  # (n_freq, 12) E|noise|^2
    pole: ComplexArray  # (6,) of the modes in the band, rad/s
    modal_constant: FloatArray  # (6, 12) 1/kg

    @property
    def frequency(self) -> FloatArray:
        """(6,) Hz."""
        return np.asarray(np.abs(self.pole) / (2 * np.pi))

    @property
    def loss_factor(self) -> FloatArray:
        """(6,)."""
        return np.asarray(-2 * self.pole.real / np.abs(self.pole))


def six_modes(
    decibels: float, seed: int, *, shapes_seed: int = 6, lower: float = 0.0, upper: float = 140.0
) -> Synthetic:
    """Return receptances at every 0.125 Hz, with complex noise so far below the rms of each FRF.

    The mean of |noise|^2 is 10^(-decibels/10) of the mean of |receptance|^2 over the band; an FRF's
    peaks are some 20 dB above its rms. Damping is viscous:
    `H = sum A/(omega_r^2 - omega^2 + 2 i zeta omega_r omega)`.

    Parameters
    ----------
    decibels
        Noise below the rms.
    seed
        Of the noise.
    shapes_seed
        Of the real shapes: standard normal, but 1 at the drive point, so that modal constants are
        of order one.
    lower, upper
        Band, Hz.
    """
    freq: FloatArray = np.arange(lower, upper + 1e-9, 0.125)
    shapes = np.random.default_rng(shapes_seed).standard_normal((len(FREQUENCIES), N_FRF))
    shapes[:, 0] = 1.0  # the drive point is near no node
    constants = shapes * shapes[:, :1]
    omega = 2 * np.pi * freq[:, None]
    natural = 2 * np.pi * FREQUENCIES
    gap = natural**2 - omega**2 + 2j * DAMPING_RATIOS * natural * omega
    exact = (1 / gap) @ constants
    variance = np.tile(10 ** (-decibels / 10) * np.mean(np.abs(exact) ** 2, axis=0), (len(freq), 1))
    rng = np.random.default_rng(seed)
    unit = (rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)) / np.sqrt(2)
    pole = natural * (-DAMPING_RATIOS + 1j * np.sqrt(1 - DAMPING_RATIOS**2))
    return Synthetic(
        freq,
        np.asarray(exact, complex),
        np.asarray(exact + np.sqrt(variance) * unit, complex),
        variance,
        np.asarray(pole[:N_IN_BAND], complex),
        np.asarray(constants[:N_IN_BAND]),
    )


HAMMERED = np.array([52.5, 144.6, 283.1, 468.3, 698.5, 973.0, 1293.0, 1655.0])  # Hz
HAMMERED_LOSS = np.array([36.0, 14.0, 8.0, 4.3, 3.7, 4.5, 4.3, 7.0]) * 1e-4
KNEE = 900.0  # Hz, where noise in a record of the force is as large as the force
PULSE = 1 / 8  # s of that record that are kept: its noise is smooth over 8 Hz
PULSES = 40  # that noise is made of


def hammered(seed: int, n_frf: int) -> FrfSet:
    """Return inertances, m/s^2/N, at lines up to 2 kHz, of eight modes that a hammer excites.

    Each FRF is of blows of its own. Noise in the short record of a blow's force is a smooth function of
    frequency: `X/(F + N)` has peaks where F + N is nearly zero, as smooth as resonances, and in every FRF
    others. The force falls with the fourth power of frequency. On top are 1e-4 of each line.
    """
    rng = np.random.default_rng(seed)
    freq: FloatArray = np.arange(0.25, 2000.0, 0.25)
    omega = 2 * np.pi * freq[:, None]
    constants = rng.uniform(0.3, 1, (len(HAMMERED), n_frf)) * rng.choice([-1, 1], (len(HAMMERED), n_frf))
    eigenvalues = (2 * np.pi * HAMMERED) ** 2 * (1 + 1j * HAMMERED_LOSS)
    exact = -(omega**2) * ((1 / (eigenvalues - omega**2)) @ constants)
    at = rng.uniform(0, PULSE, (PULSES, n_frf))
    size = (rng.standard_normal(at.shape) + 1j * rng.standard_normal(at.shape)) / np.sqrt(2 * PULSES)
    noise = sum(size[k] * np.exp(-1j * omega * at[k]) for k in range(PULSES))
    unit = rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)
    inertance = np.asarray(exact / (1 + (freq[:, None] / KNEE) ** 4 * noise) * (1 + 1e-4 * unit), complex)
    dofs = tuple(Dof(node, "X") for node in range(1, n_frf + 1))
    return FrfSet(freq, inertance[:, :, None], dofs, (Dof(30, "X"),), FrfKind.INERTANCE)
