"""Partial coherence of a response with each of several simultaneous forces, from the multiple coherence."""

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.estimation.spectra import CrossSpectra


def partial_coherence(
    values: ComplexArray, multiple: FloatArray, forces: ComplexArray | None = None
) -> FloatArray:
    """Return the partial coherence of each response with each force, without the parts due to other forces.

    The incoherent part of a response is noise for each of its FRFs: its spectrum is (1 - g2)/g2 times the
    coherent one, H* G_ff H^T of the row H of its FRFs. Of force k only the part that is incoherent with the
    other forces counts, 1/(G_ff^-1)_kk, so that

        (1 - g2_k)/g2_k = (1 - g2)/g2 . (H* G_ff H^T) (G_ff^-1)_kk / |H_k|^2

    and the variance of H_k from n averages of n_in random forces is |H_k|^2 (1 - g2_k)/g2_k over n - n_in.
    With one force g2_k is the coherence itself. It does not apply to forces that act one after the other.

    Parameters
    ----------
    values
        (n_freq, n_out, n_in) FRFs of any kind.
    multiple
        (n_freq, n_out) multiple coherence, 0 to 1.
    forces
        (n_freq, n_out, n_in, n_in) cross spectra G_jk = E[conj(F_j) F_k], N^2/Hz; None: uncorrelated
        forces of equal power. Of n_out = 1 where they are the same for all responses.

    Returns
    -------
    (n_freq, n_out, n_in), 0 to 1.

    References
    ----------
    Bendat, J. S. and Piersol, A. G. (2010), Random Data, 4th ed., sections 7.3 and 9.3.
    """
    total_coherence = multiple[:, :, None]
    if values.shape[2] == 1:
        return total_coherence
    power = np.abs(values) ** 2
    if forces is None:
        total = power.sum(axis=2, keepdims=True)
        alone = power
    else:
        total = ((values[..., None, :].conj() @ forces) @ values[..., None])[..., 0].real
        alone = power / conditioned_variance(forces)
    fraction = alone / np.where(total > 0, total, 1.0)
    coherent_part = total_coherence * fraction
    return np.minimum(coherent_part / np.maximum(coherent_part + 1 - total_coherence, PRODUCT_ROUNDING), 1.0)


def coherence_of_frfs(spectra: CrossSpectra, h: ComplexArray, multiple: FloatArray) -> FloatArray:
    """Return the partial coherence of each response with each force, (n_run, n_freq, n_out, n_in).

    Parameters
    ----------
    spectra
        Averaged spectra of all runs.
    h
        (n_run, n_freq, n_out, n_in) their H1.
    multiple
        (n_run, n_freq, n_out) their multiple coherence.
    """
    runs = zip(h, multiple, spectra.ff[:, :, None], strict=True)
    return np.array([partial_coherence(*run) for run in runs])


def conditioned_variance(forces: ComplexArray) -> FloatArray:
    """Return (G_ff^-1)_kk, (.., n_in): one over the conditioned spectrum of each force, without the others.

    It is infinite for a force that is 0 or a linear combination of the others.

    Parameters
    ----------
    forces
        (.., n_in, n_in) cross spectra, N^2/Hz.
    """
    coherence, size, regular = regular_coherence(forces)
    own, safe = np.arange(forces.shape[-1]), np.where(size > 0, size, 1.0)
    inverse = np.linalg.inv(coherence)[..., own, own].real / safe**2
    return np.where(regular[..., None] & (size > 0), inverse, np.inf)


def regular_coherence(forces: ComplexArray) -> tuple[ComplexArray, FloatArray, BoolArray]:
    """Return G_ff over the square roots of its diagonal, these, and whether the forces are independent.

    Of dependent forces the unit matrix.

    Parameters
    ----------
    forces
        (.., n_in, n_in) cross spectra, N^2/Hz.
    """
    own = np.arange(forces.shape[-1])
    size = np.sqrt(np.maximum(forces[..., own, own].real, 0.0))
    safe = np.where(size > 0, size, 1.0)
    coherence = forces / (safe[..., :, None] * safe[..., None, :])
    coherence[..., own, own] = 1.0
    regular = np.linalg.det(coherence).real > PRODUCT_ROUNDING
    return np.where(regular[..., None, None], coherence, np.eye(len(own))), size, regular
