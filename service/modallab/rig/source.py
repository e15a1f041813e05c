"""What the source plays, and the noise of the channels that listen."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Source:
    """How the source's power stands to the record; `continuous` of it does not repeat and leaks."""

    continuous: float = 0.0


@dataclass(frozen=True)
class NoiseLevels:
    """White noise of the channels as ratios to the mean noise-free spectrum of each over the band."""

    force: float = 0.0
    response: float = 0.0
