"""Impact of a hammer."""

from collections.abc import Iterator

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.excitation import EXCITATIONS, Excitation, ExcitationSetting
from modallab.rig.hammer import pulse_spectrum, pulse_width, tilt_factors, tilt_moments
from modallab.rig.impulse_responses import ImpulseResponses


class Blow:
    """Half-sine pulse after a pre-trigger; amplitudes scatter from blow to blow.

    A blow beside its point is the same force and a lever's moment with it, one at an angle less force
    along the axis and some across; the gauge in the hammer shows all of it. Sizes are log-normal, their
    mean square that of a blow of the declared level.
    """

    def spectrum(self, omega: FloatArray, setting: ExcitationSetting) -> ComplexArray:
        """Return the pulse's transform over its value at 0 Hz."""
        return pulse_spectrum(omega, pulse_width(setting.tip_stiffness, setting.hammer_mass))

    def misaligned(self, setting: ExcitationSetting) -> bool:
        """Return whether the place or the angle of blows scatters."""
        return setting.place_scatter > 0 or setting.angle_scatter > 0

    def expected_records(self, answers: ImpulseResponses, setting: ExcitationSetting) -> Iterator[FloatArray]:
        """Yield as many blows as basis records, with the same mean spectra as all blows."""
        eigenvalues, eigenvectors = np.linalg.eigh(self.moments(len(answers.samples), setting))
        basis = eigenvectors.T * np.sqrt(len(eigenvalues) * eigenvalues.clip(min=0.0))[:, None]
        yield np.tensordot(basis, self.basis_records(answers, setting), axes=1)

    def random_records(
        self, answers: ImpulseResponses, setting: ExcitationSetting, n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return n records, (n, n_ch, n_samples)."""
        weights = self.weights(len(answers.samples), setting, n, rng)
        return np.asarray(np.tensordot(weights, self.basis_records(answers, setting), axes=1))

    def basis_records(self, answers: ImpulseResponses, setting: ExcitationSetting) -> FloatArray:
        """Return the records of a blow.

        Of a misaligned blow: first its force alone, then the responses to it along the axis, per metre
        beside the point, and across.
        """
        moment = round(setting.pre_trigger * answers.n_samples)
        records = np.sqrt(answers.n_samples) * answers.period_after(moment)
        if not self.misaligned(setting):
            return np.asarray(records)
        force, axial = records[:1].copy(), records[:1].copy()
        force[:, answers.n_in :], axial[:, : answers.n_in] = 0.0, 0.0
        return np.concatenate([force, axial, records[1:]])

    def weights(
        self, n_sources: int, setting: ExcitationSetting, n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return the weights of n blows, (n, k)."""
        s = setting.level_scatter
        size = np.exp(s * rng.standard_normal((n, 1)) - s**2)
        if not self.misaligned(setting):
            return np.asarray(size)
        place_offset = setting.place_scatter * rng.standard_normal((n, 1))
        along, across = tilt_factors(setting.angle_scatter, n, n_sources - 2, rng)
        return np.asarray(size * np.hstack([np.ones((n, 1)), along[:, None], place_offset, across]))

    def moments(self, n_sources: int, setting: ExcitationSetting) -> FloatArray:
        """Return the mean products of the weights, (k, k)."""
        if not self.misaligned(setting):
            return np.eye(1)
        n_lateral = n_sources - 2
        along, spread, across = tilt_moments(setting.angle_scatter, n_lateral)
        mean = np.array([1.0, along, 0.0, *[0.0] * n_lateral])
        variances = [0.0, spread, setting.place_scatter**2, *[across] * n_lateral]
        return np.asarray(np.outer(mean, mean) + np.diag(variances))


EXCITATIONS.register("impact")(
    Excitation(
        summary="the blow of a hammer: a pulse as short as its tip is hard and its head light",
        transient=Blow(),
        deterministic_transient=True,
        settings=(
            "level",
            "tip_stiffness",
            "hammer_mass",
            "pre_trigger",
            "level_scatter",
            "place_scatter",
            "angle_scatter",
        ),
    )
)
