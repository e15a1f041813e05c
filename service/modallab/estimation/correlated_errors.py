"""Correlation of the random errors of FRFs to several simultaneous forces, and its removal."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import nnls

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.numerics import PRODUCT_ROUNDING, SUM_ROUNDING
from modallab.estimation.partial_coherence import regular_coherence
from modallab.estimation.settings import FORCE_NOISE

_Factors = tuple[ComplexArray, ComplexArray, ComplexArray]


@dataclass(frozen=True, eq=False)
class CorrelatedErrors:
    """Covariance B + V V^H of normalised errors at each line; B couples those of one group only."""

    groups: IntArray
    """(n_group, n) columns of the errors that B couples."""
    within: ComplexArray
    """(n_freq, n_group, n, n) blocks of B."""
    common: ComplexArray
    """(n_freq, n_group, n, r) columns V: what all groups have in common."""
    _known: dict[bytes, _Factors] = field(default_factory=dict, repr=False)

    def at(self, lines: IntArray) -> "CorrelatedErrors":
        """Return the covariance at some of the lines, (n,) indices."""
        return replace(self, within=self.within[lines], common=self.common[lines], _known={})

    def decorrelated(self, errors: ComplexArray, used: BoolArray) -> ComplexArray:
        """Return errors with the inverse square root of their covariance applied, 0 where they are not used.

        With the Cholesky factor B = L L^H and W = L^-1 V that is (I + W W^H)^(-1/2) L^-1.

        Parameters
        ----------
        errors
            (.., n_freq, n_columns), of unit variance.
        used
            (n_freq, n_columns) errors that are included.
        """
        inverse, common, weighted = self._factors(used)
        masked = np.where(used, errors, 0.0)[..., self.groups]
        scaled = (inverse @ masked[..., None])[..., 0]
        along = np.einsum("fgnr,...fgn->...fr", common.conj(), scaled)
        out = np.zeros(errors.shape, complex)
        out[..., self.groups] = scaled - np.einsum("fgnr,...fr->...fgn", weighted, along)
        return out

    def _factors(self, used: BoolArray) -> _Factors:
        """Return L^-1, W, and W M with (I + W W^H)^(-1/2) = I - W M W^H."""
        key = used.tobytes()
        if key not in self._known:
            self._known.clear()  # a fit asks for one mask again and again
            self._known[key] = self._solve(used[:, self.groups])
        return self._known[key]

    def _solve(self, used: BoolArray) -> _Factors:
        both = used[..., :, None] & used[..., None, :]
        within = np.where(both, self.within, 0.0) + (~used)[..., None] * np.eye(used.shape[2])
        inverse = np.linalg.inv(np.linalg.cholesky(within))
        common = inverse @ np.where(used[..., None], self.common, 0.0)
        size, rotation = np.linalg.eigh(np.einsum("fgnr,fgns->frs", common.conj(), common))
        size = np.maximum(size, SUM_ROUNDING)
        weight = (rotation * ((1 - 1 / np.sqrt(1 + size)) / size)[:, None]) @ rotation.conj().swapaxes(1, 2)
        return inverse, common, np.einsum("fgnr,frs->fgns", common, weight)


@dataclass(frozen=True, eq=False)
class IncoherentShares:
    """Amplitudes of the incoherent responses of a run, of unit power, that noise of each force has."""

    values: ComplexArray
    """(n_freq, n_out, n_in)."""

    @classmethod
    def of(cls, h: ComplexArray, incoherent: FloatArray, lines: BoolArray) -> "IncoherentShares":
        """Return the shares of white noise of the forces beside white noise of the responses.

        Parameters
        ----------
        h
            (n_freq, n_out, n_in) FRFs of the motion whose noise is white.
        incoherent
            (n_freq, n_out) incoherent spectra of the responses.
        lines
            (n_freq,) lines that the noises are estimated from.
        """
        gain = np.abs(h) ** 2
        force, response = white_noises(incoherent[lines], gain[lines])
        white = gain @ force + response
        total = np.where(incoherent > FORCE_NOISE.outlier_ratio * white, incoherent, white)
        values = h * np.sqrt(force / np.where(total > 0, total, 1.0)[..., None])
        share = (np.abs(values) ** 2).sum(axis=2, keepdims=True)
        limit = FORCE_NOISE.max_common_fraction
        return cls(values * np.sqrt(np.minimum(1.0, limit / np.where(share > 0, share, 1.0))))

    def of_responses(self, columns: IntArray) -> CorrelatedErrors:
        """Return the correlation of the logarithms of incoherent spectra: their coherence with each other.

        Parameters
        ----------
        columns
            (n_out,) columns of the spectra.
        """
        products = self.values[..., :, None] * self.values[..., None, :].conj()
        rows, others = np.triu_indices(products.shape[-1], 1)
        above = np.sqrt(2) * products[..., rows, others]
        own = np.diagonal(products, axis1=-2, axis2=-1)
        common = np.concatenate([own, above.real, above.imag], axis=-1)
        within = 1 - (common.real**2).sum(axis=-1)
        return CorrelatedErrors(
            columns[:, None], within[..., None, None].astype(complex), common[..., None, :]
        )

    def of_frfs(
        self, h: ComplexArray, forces: ComplexArray, random: FloatArray, columns: IntArray
    ) -> CorrelatedErrors:
        """Return the correlation of the relative errors of FRFs.

        Errors of H_aj and H_bk have the covariance S_ab (G_ff^-1)_jk / n, S the cross spectra of the
        incoherent responses: noise of their own, and noise of each force l in proportion to H_al.

        Parameters
        ----------
        h
            (n_freq, n_out, n_in) FRFs.
        forces
            (n_freq, n_in, n_in) cross spectra of the forces.
        random
            (n_freq, n_out, n_in) share of the variance of each FRF that is due to incoherent responses.
        columns
            (n_out, n_in) columns of the FRFs.
        """
        correlation = _inverse_correlation(forces)
        size = np.abs(h)
        phase = np.where(size > 0, h, 1.0).conj() / np.where(size > 0, size, 1.0)
        scale = np.sqrt(random) * phase
        own = 1 - (np.abs(self.values) ** 2).sum(axis=2)
        coupled = own[..., None, None] * scale[..., :, None] * scale[..., None, :].conj()
        within = coupled * correlation[:, None] + (1 - random)[..., None] * np.eye(h.shape[2])
        root = np.linalg.cholesky(correlation)
        common = scale[..., None, None] * self.values[:, :, None, :, None] * root[:, None, :, None, :]
        return CorrelatedErrors(columns, within, common.reshape(*h.shape, -1))


def white_noises(incoherent: FloatArray, gain: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return white noise of the forces (n_in,) and of the responses (n_out,) that add up to incoherent power.

    Least squares of relative differences with bounds at 0; lines with more than both are left out, as in
    `ForceChannelNoise`.

    Parameters
    ----------
    incoherent
        (n_freq, n_out).
    gain
        (n_freq, n_out, n_in) squared FRFs.
    """
    n_out, n_in = gain.shape[1:]
    size = np.median(incoherent, axis=0) + np.finfo(float).tiny
    unit = size.mean() / np.maximum(np.median(gain.sum(axis=1), axis=0), np.finfo(float).tiny)
    white = np.maximum(incoherent, FORCE_NOISE.min_coherence * size)
    noise = np.zeros(n_in + n_out)
    for _ in range(FORCE_NOISE.iterations):
        weight = (incoherent < FORCE_NOISE.outlier_ratio * white) / white
        forces, responses = (gain * unit) * weight[..., None], weight * size
        cross = np.einsum("foi,fo->io", forces, responses)
        normal = np.block(
            [
                [np.einsum("foi,foj->ij", forces, forces), cross],
                [cross.T, np.diag((responses**2).sum(axis=0))],
            ]
        )
        target = weight * incoherent
        right = np.concatenate([np.einsum("foi,fo->i", forces, target), (responses * target).sum(axis=0)])
        scale = float(np.trace(normal)) + np.finfo(float).tiny
        root = np.linalg.cholesky(normal / scale + PRODUCT_ROUNDING * np.eye(len(normal)))
        latest, noise = noise, nnls(root.T, np.linalg.solve(root, right / scale))[0]
        white = gain @ (noise[:n_in] * unit) + noise[n_in:] * size
        white = np.maximum(white, FORCE_NOISE.min_coherence * size)
        if np.allclose(noise, latest, rtol=FORCE_NOISE.min_coherence, atol=0.0):
            break
    return noise[:n_in] * unit, noise[n_in:] * size


def _inverse_correlation(forces: ComplexArray) -> ComplexArray:
    """Return G_ff^-1 (n_freq, n_in, n_in) with a diagonal of 1; the unit matrix of dependent forces."""
    coherence, _, _ = regular_coherence(forces)
    inverse, own = np.linalg.inv(coherence), np.arange(forces.shape[-1])
    size = np.sqrt(inverse[..., own, own].real)
    return np.asarray(inverse / (size[..., :, None] * size[..., None, :]))
