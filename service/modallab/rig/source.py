"""Source signal and channel noise."""

from dataclasses import dataclass, replace

from modallab.core.dof import Dof
from modallab.rig.channel import Filter


@dataclass(frozen=True)
class Source:
    """Source signal; its share `continuous` does not repeat with the record and leaks."""

    continuous: float = 0.0
    shaping: tuple[Filter, ...] = ()
    """Filters of transient excitations, which begin and end within a record."""

    def with_filter(self, filter_: Filter) -> "Source":
        """Return the source with one more filter in series."""
        return replace(self, shaping=(*self.shaping, filter_))


@dataclass(frozen=True)
class NoiseLevels:
    """White noise of the channels as ratios to the mean noise-free spectrum of each over the band."""

    force: float = 0.0
    response: float = 0.0
    gauges: tuple[tuple[Dof, float], ...] = ()
    """Noise ratios of force gauges at single drive points, in addition to `force`."""

    def of_gauge(self, drive: Dof) -> float:
        """Return the noise ratio of the force gauge at a drive point."""
        return self.force + sum(ratio for dof, ratio in self.gauges if dof.point == drive.point)
