"""The rig as its log book has it: hardware, analyser settings, where it drives and listens."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import EffectSpec


def _within(name: str, value: float, lower: float, upper: float) -> None:
    if not lower <= value <= upper:  # NaN fails too
        raise InvalidInputError(
            f"{name} is out of bounds", field=name, value=value, allowed=f"{lower} to {upper}"
        )


# The bounds below are those of the effects that the hardware implies: what a log book may declare,
# an effect can be (an armature may have the gauge's cancelled mass to carry as well).
@dataclass(frozen=True)
class Exciter:
    """What drives the structure."""

    kind: Literal["shaker", "hammer"] = "shaker"
    armature_mass: float = 0.0  # kg, behind the force transducer

    def __post_init__(self) -> None:
        _within("armature_mass", self.armature_mass, 0.0, 4.5)


@dataclass(frozen=True)
class ForceTransducer:
    """The gauge at the drive point."""

    mass_below: float = 0.0  # kg, between the sensing element and the structure
    mass_cancelled: bool = False  # True: the analyser has taken that mass out of the force already

    def __post_init__(self) -> None:
        _within("mass_below", self.mass_below, 0.0, 0.5)


@dataclass(frozen=True)
class Accelerometers:
    """The response transducers: one at every response DoF, or one that roves over them."""

    mass: float = 0.0  # kg each, with stud
    roving: bool = False

    def __post_init__(self) -> None:
        _within("accelerometers.mass", self.mass, 0.0, 0.5)


@dataclass(frozen=True)
class Noise:
    """White noise as a ratio to the mean of the noise-free spectrum over the band."""

    force: float = 0.0
    response: float = 0.0

    def __post_init__(self) -> None:
        _within("noise.force", self.force, 0.0, 10.0)
        _within("noise.response", self.response, 0.0, 10.0)


@dataclass(frozen=True)
class ExcitationSetting:
    """Which signal the source plays, and how loud."""

    kind: str = "periodic_random"
    level: float = 1.0  # N rms, flat from 0 Hz to the top of the band

    def __post_init__(self) -> None:
        _within("excitation.level", self.level, 1e-9, 1e9)


@dataclass(frozen=True)
class Analyser:
    """Settings of the FFT analyser."""

    frequency_max: float = 800.0  # Hz
    n_lines: int = 401  # 0 Hz counted
    window: str = "rectangular"
    averages: int = 100
    overlap: float = 0.0  # share of a record, 0 to 0.9
    estimator: str = "h1"
    excitation: ExcitationSetting = field(default_factory=ExcitationSetting)

    def __post_init__(self) -> None:
        _within("frequency_max", self.frequency_max, 1e-3, 1e6)
        _within("n_lines", self.n_lines, 8, 20001)
        _within("averages", self.averages, 1, 100_000)
        _within("overlap", self.overlap, 0.0, 0.9)

    @property
    def freq(self) -> FloatArray:
        """(n_lines,) Hz, from 0."""
        return np.linspace(0.0, self.frequency_max, self.n_lines)

    @property
    def spacing(self) -> float:
        """Distance of two lines, Hz."""
        return self.frequency_max / (self.n_lines - 1)

    @property
    def record_length(self) -> float:
        """Length of one record, s."""
        return 1.0 / self.spacing


@dataclass(frozen=True)
class Shot:
    """Channels acquired together: one run of the analyser."""

    drives: tuple[Dof, ...]  # driven at the same time
    outputs: tuple[Dof, ...]
    moment: float = 0.0  # 0 for the first run of the test, 1 for the last

    @property
    def drive(self) -> Dof:
        """The first drive point."""
        return self.drives[0]


@dataclass(frozen=True)
class RigSetup:
    """A rig as declared; parts left out are ideal.

    Several shakers drive at the same time; a hammer strikes one drive point after the other.
    """

    drives: tuple[Dof, ...]
    responses: tuple[Dof, ...]
    exciter: Exciter = field(default_factory=Exciter)
    force_transducer: ForceTransducer = field(default_factory=ForceTransducer)
    accelerometers: Accelerometers = field(default_factory=Accelerometers)
    analyser: Analyser = field(default_factory=Analyser)
    noise: Noise = field(default_factory=Noise)
    effects: tuple[EffectSpec, ...] = ()

    def __post_init__(self) -> None:
        for dofs, name, part in (
            (self.drives, "drive" if len(self.drives) == 1 else "drives", "a drive point"),
            (self.responses, "responses", "a response"),
        ):
            if not dofs:
                raise InvalidInputError(f"a rig needs {part}", field=name, allowed="one DoF or more")
            if len({dof.point for dof in dofs}) < len(dofs):
                raise InvalidInputError(f"{part} is named twice", field=name)
            for dof in dofs:
                if not dof.translational:
                    raise InvalidInputError(
                        f"{dof} is a rotation: a force and an accelerometer act along X, Y or Z",
                        field=name,
                        value=str(dof),
                        allowed="X, Y, Z",
                    )

    @property
    def drive(self) -> Dof:
        """The first drive point."""
        return self.drives[0]

    @property
    def shots(self) -> tuple[Shot, ...]:
        """The runs of the test.

        One for each position of what roves: of the accelerometer, of the hammer, or of both.
        """
        roving = self.accelerometers.roving
        outputs = [(response,) for response in self.responses] if roving else [self.responses]
        drives = [(drive,) for drive in self.drives] if self.exciter.kind == "hammer" else [self.drives]
        runs = [(d, o) for d in drives for o in outputs]
        last = max(len(runs) - 1, 1)
        return tuple(Shot(d, o, i / last) for i, (d, o) in enumerate(runs))
