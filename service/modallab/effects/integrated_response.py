"""Response that is another derivative of the motion than the log book says."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar, Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.parameters import ParameterSpec, parameter
from modallab.core.place import Channels, Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import INTEGRATION
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import RigSetup


@EFFECTS.register("integrated_response")
@dataclass(frozen=True)
class IntegratedResponse(Effect):
    """Response integrated over time against the log book, H' = factor H / (i omega)^integrations.

    Velocity in place of the acceleration of the log book is integrated once, displacement twice; -1 is
    acceleration in place of velocity. The factor is that of the units: 1000 for mm/s in place of m/s^2. A
    diagnosis compares whole numbers of integrations and fits the factor. Ewins, Modal Testing (2000),
    section 2.1, on receptance, mobility and accelerance.
    """

    kind: ClassVar[str] = "integrated_response"
    summary: ClassVar[str] = "velocity or displacement in place of the acceleration of the log book"
    stage: ClassVar[Stage] = Stage.CHANNEL
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Channels)
    integrations: float = parameter(
        1.0,
        unit="1",
        lower=-2.0,
        upper=2.0,
        doc="whole number of integrations over time, negative: differentiations",
    )
    factor: float = parameter(
        1.0, unit="1", lower=1e-6, upper=1e9, absent=None, doc="unit in the log book over that of the reading"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.integrations != round(self.integrations):
            raise InvalidInputError(
                "a response is integrated a whole number of times",
                field="integrations",
                value=self.integrations,
                allowed=[-2, -1, 0, 1, 2],
            )

    def with_parameters(self, values: dict[str, float]) -> Self:
        """Return the same effect with other parameters, the integrations as a whole number away from 0."""
        if times := values.get("integrations"):
            values = {**values, "integrations": float(np.copysign(max(1, round(abs(times))), times))}
        return replace(self, **values)  # type: ignore[arg-type]

    def fitted_specs(self) -> list[tuple[str, ParameterSpec, float]]:
        """Return what a fit varies: the factor alone, as there is nothing between whole numbers."""
        return [spec for spec in super().fitted_specs() if spec[0] != "integrations"]

    def on_channel(self, channel: Channel, system: DynamicSystem) -> Channel:
        if not self.acts_on_channel(channel) or not self.integrations:
            return channel
        return channel.with_filter(self._transfer)

    def _transfer(self, omega: FloatArray) -> ComplexArray:
        """Return factor / (i omega)^integrations, (n_freq,), and 0 at 0 Hz."""
        transfer = np.zeros(len(omega), complex)
        moving = omega > 0
        transfer[moving] = self.factor * (1j * omega[moving]) ** -self.integrations
        return transfer

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return the whole numbers, and factors of usual units."""
        return {"integrations": INTEGRATION.integrations, "factor": INTEGRATION.factors}

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return all responses and each."""
        return (None, *(Channels((dof,)) for dof in setup.responses))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return how many more than half of the lines of a response have a ratio like a power of i omega.

        Of an integration ln(H'/H) = ln(factor) - ln(omega) - i pi/2: its real part over its imaginary part is
        a line over ln(omega) of slope 2/pi, whatever the factor, and whatever the random error of a line.
        The lower half of the lines counts alone too, and half of those, to the lowest eighth: noise drowns a
        displacement at high frequencies.
        """
        residual, lines = evidence.frf, (evidence.freq > 0)[:, None] & (evidence.weight > 0)
        turned = np.maximum(np.abs(residual.imag), SAFE_DIVISOR)
        ratio = np.where(lines & (residual.imag != 0), 0.5 * np.pi * residual.real / turned, np.nan)
        course = np.log(np.maximum(evidence.freq, SAFE_DIVISOR))[:, None]
        ends = [len(course) // parts for parts in (1, 2, 4, 8)]
        return max(_suspicion(ratio[:end], course[:end]) for end in ends)


def _suspicion(ratio: FloatArray, course: FloatArray) -> float:
    """Return the suspicion of an integration, 0 to 1; `ratio` (n_freq, n_out) and `course` (n_freq, 1)."""
    integrated, differentiated, constant = (_alike(ratio + sign * course) for sign in (1, -1, 0))
    share = np.maximum(integrated, differentiated)
    # A reversed sign is a turn of half a circle without a slope.
    share = np.where(share > constant, share, 0.0)
    least = INTEGRATION.least_share
    return float(np.clip((share - least) / (1 - least), 0.0, 1.0).max(initial=0.0))


def _alike(values: FloatArray) -> FloatArray:
    """Return the share (n_out,) of values (n_freq, n_out) near their median; of lines that have one."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    shares = np.zeros(values.shape[1])
    for i in np.flatnonzero(count >= INTEGRATION.least_lines):
        chosen = values[known[:, i], i]
        shares[i] = (np.abs(chosen - np.median(chosen)) < INTEGRATION.nearness).mean()
    return shares
