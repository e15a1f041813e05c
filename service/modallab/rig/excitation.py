"""Kinds of excitation: source signals and their relation to the analyser's record."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Literal, Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.parameters import ParameterSpec, parameter
from modallab.core.registry import Family
from modallab.rig.hardware import within
from modallab.rig.impulse_responses import ImpulseResponses

Phases = Callable[[int], FloatArray]  # number of lines -> rad, 0 at 0 Hz


def swept_phases(n_lines: int) -> FloatArray:
    """Return phases, rad, (n_lines,), whose group delay rises evenly over the record: -pi k^2/n.

    Line k comes k/n of the record after line 0, and no peak stands out. Schroeder (1970), IEEE Trans.
    Information Theory 16, 85-89.
    """
    return np.asarray(-np.pi * np.arange(n_lines) ** 2 / (n_lines - 1))


@dataclass(frozen=True)
class ExcitationSetting:
    """Kind and level of the source signal.

    The mean square of a signal over the band is level^2, whatever its kind; of a burst and of a blow
    that of the record as a whole, a blow's as if its spectrum stayed what it is at low frequency.
    """

    kind: str = "periodic_random"
    """Kind of signal."""
    level: float | None = parameter(
        1.0, unit="N", lower=1e-9, upper=1e9, absent=None, doc="rms of the source, flat over the band"
    )
    burst: float = parameter(
        0.5, unit="1", lower=0.01, upper=1.0, absent=None, doc="share of the record in which the source plays"
    )
    tip_stiffness: float = parameter(
        1e7, unit="N/m", lower=1e3, upper=1e11, absent=None, doc="hammer's tip: rubber 1e6, steel 1e8"
    )
    hammer_mass: float = parameter(
        0.2, unit="kg", lower=1e-3, upper=20.0, absent=None, doc="of the hammer's head"
    )
    pre_trigger: float = parameter(
        0.05, unit="1", lower=0.0, upper=0.5, absent=None, doc="share of the record before the blow"
    )
    level_scatter: float = parameter(
        0.0, unit="1", lower=0.0, upper=1.0, doc="standard deviation of the logarithm of a blow's size"
    )
    place_scatter: float = parameter(
        0.0, unit="m", lower=0.0, upper=1.0, doc="standard deviation of a blow's place along the member"
    )
    angle_scatter: float = parameter(
        0.0, unit="rad", lower=0.0, upper=0.8, doc="standard deviation of a blow's tilt to either side"
    )

    band: tuple[float, float] | None = None
    """Hz, lowest and highest frequency that the source drives; None: the whole band of the analyser."""
    shape: Literal["flat", "unknown"] = "flat"
    """Spectrum of the source over its band: `flat`, or `unknown`, which a diagnosis leaves free."""

    def __post_init__(self) -> None:
        EXCITATIONS[self.kind]
        for name, spec in self.specs().items():
            if (value := getattr(self, name)) is not None:
                within(f"excitation.{name}", value, spec.lower, spec.upper)
        if self.band is not None and not 0 <= self.band[0] < self.band[1]:
            raise InvalidInputError(
                "a band ends above its beginning",
                field="excitation.band",
                value=list(self.band),
                allowed="[low, high], Hz",
            )

    @classmethod
    def specs(cls) -> dict[str, ParameterSpec]:
        """Return unit, bounds and meaning of every number by name."""
        return {f.name: f.metadata["spec"] for f in fields(cls) if "spec" in f.metadata}


class Transient(Protocol):
    """A signal that begins and ends within a record, on a structure at rest when the record begins."""

    def spectrum(self, omega: FloatArray, setting: ExcitationSetting) -> ComplexArray:
        """Return the source spectrum (n_freq,) over that of white noise or of a unit impulse."""

    def misaligned(self, setting: ExcitationSetting) -> bool:
        """Return whether forces act beside the drive point or off its axis."""

    def expected_records(self, answers: ImpulseResponses, setting: ExcitationSetting) -> Iterator[FloatArray]:
        """Yield batches of records (n, n_ch, n_samples) with the expected mean spectra."""

    def random_records(
        self, answers: ImpulseResponses, setting: ExcitationSetting, n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return n random records, (n, n_ch, n_samples)."""

    def basis_records(self, answers: ImpulseResponses, setting: ExcitationSetting) -> FloatArray | None:
        """Return the records (k, n_ch, n_samples) that span every record; None if it is Gaussian."""

    def weights(
        self, n_sources: int, setting: ExcitationSetting, n: int, rng: np.random.Generator
    ) -> FloatArray:
        """Return the weights (n, k) of the basis records in n random records.

        Parameters
        ----------
        n_sources
            Of the impulse responses: declared ones and forces beside them.
        """

    def moments(self, n_sources: int, setting: ExcitationSetting) -> FloatArray:
        """Return the second moments of the weights, (k, k)."""


@dataclass(frozen=True)
class Excitation:
    """A kind of signal the source can play.

    By default a signal is Gaussian, independent from record to record, and periodic in the record.
    """

    summary: str
    continuous: float = 0.0  # share of its power that does not repeat with the record, and so leaks
    phases: Phases | None = None  # of its lines, all of one size, where every record has the same
    line_by_line: bool = False  # every line is measured on its own: no window, all of the power in a line
    transient: Transient | None = None  # it begins and ends within a record, on a structure at rest
    deterministic_transient: bool = (
        False  # of what begins and ends within a record: whether the next has the same
    )
    settings: tuple[str, ...] = ("level",)  # what of `ExcitationSetting` it asks for

    def specs(self) -> dict[str, ParameterSpec]:
        """Return unit, bounds and meaning of the numbers it asks for, by name."""
        all_specs = ExcitationSetting.specs()
        return {name: all_specs[name] for name in self.settings}

    @property
    def deterministic(self) -> bool:
        """Whether every record has the same signal but for its amplitude."""
        return self.phases is not None or self.deterministic_transient

    def noise_share(self, n_lines: int) -> float:
        """Return the noise of a line over that of broadband excitation of the same rms."""
        return 1 / (n_lines - 1) if self.line_by_line else 1.0


EXCITATIONS: Family[Excitation] = Family("excitation", home="modallab.rig.excitations")
"""Excitations, one file each."""
