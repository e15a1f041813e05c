"""Wire types of rigs; parts left out are ideal."""

from dataclasses import asdict
from typing import Annotated, Any, Literal, Self

from pydantic import Field

from modallab.api.wire import Count, DofText, Effects, EntryOut, Number, Text, Wire, effect_out
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import (
    Accelerometers,
    Analyser,
    ExcitationSetting,
    Exciter,
    ForceTransducer,
    Noise,
    RigSetup,
)
from modallab.store.base import Entry

_DEFAULT = Analyser()
# Lines x responses of one test: its arrays take some hundred megabytes while they are made.
_MOST_VALUES = 2_000_000


class ExciterIn(Wire):
    """What drives the structure."""

    kind: Literal["shaker"] = "shaker"
    armature_mass: Number = 0.0

    def to_domain(self) -> Exciter:
        """Return the exciter."""
        return Exciter(self.kind, self.armature_mass)


class ForceTransducerIn(Wire):
    """The gauge at the drive point."""

    mass_below: Number = 0.0
    mass_cancelled: bool = False

    def to_domain(self) -> ForceTransducer:
        """Return the force transducer."""
        return ForceTransducer(self.mass_below, self.mass_cancelled)


class AccelerometersIn(Wire):
    """The response transducers."""

    mass: Number = 0.0
    roving: bool = False

    def to_domain(self) -> Accelerometers:
        """Return the accelerometers."""
        return Accelerometers(self.mass, self.roving)


class ExcitationIn(Wire):
    """The signal of the source, N rms from 0 Hz to the top of the band."""

    kind: Text = _DEFAULT.excitation.kind
    level: Number = _DEFAULT.excitation.level

    def to_domain(self) -> ExcitationSetting:
        """Return the excitation; an unknown kind raises."""
        EXCITATIONS[self.kind]
        return ExcitationSetting(self.kind, self.level)


class AnalyserIn(Wire):
    """Settings of the analyser; `n_lines` counts 0 Hz."""

    frequency_max: Number = _DEFAULT.frequency_max
    n_lines: Count = _DEFAULT.n_lines
    window: Text = _DEFAULT.window
    averages: Count = _DEFAULT.averages
    overlap: Number = _DEFAULT.overlap
    estimator: Text = _DEFAULT.estimator
    excitation: ExcitationIn = ExcitationIn()

    def to_domain(self) -> Analyser:
        """Return the analyser; unknown names raise."""
        WINDOWS[self.window]
        ESTIMATORS[self.estimator]
        return Analyser(
            frequency_max=self.frequency_max,
            n_lines=self.n_lines,
            window=self.window,
            averages=self.averages,
            overlap=self.overlap,
            estimator=self.estimator,
            excitation=self.excitation.to_domain(),
        )


class NoiseIn(Wire):
    """Noise as a ratio to the mean of each channel's noise-free spectrum."""

    force: Number = 0.0
    response: Number = 0.0

    def to_domain(self) -> Noise:
        """Return the noise."""
        return Noise(self.force, self.response)


class RigIn(Wire):
    """The log book of a test."""

    drive: DofText | None = None
    drives: Annotated[list[DofText], Field(min_length=1, max_length=100)] | None = None
    responses: Annotated[list[DofText], Field(min_length=1, max_length=2000)]
    exciter: ExciterIn | None = None
    stinger: None = None
    force_transducer: ForceTransducerIn | None = None
    accelerometers: AccelerometersIn | None = None
    analyser: AnalyserIn | None = None
    noise: NoiseIn | None = None
    effects: Effects = ()

    def to_domain(self) -> RigSetup:
        """Return the rig; `InvalidInputError` where it makes no sense or asks for too much."""
        setup = RigSetup(
            drives=self._drives(),
            responses=tuple(Dof.parse(text, field="responses") for text in self.responses),
            exciter=(self.exciter or ExciterIn()).to_domain(),
            force_transducer=(self.force_transducer or ForceTransducerIn()).to_domain(),
            accelerometers=(self.accelerometers or AccelerometersIn()).to_domain(),
            analyser=(self.analyser or AnalyserIn()).to_domain(),
            noise=(self.noise or NoiseIn()).to_domain(),
            effects=tuple(effect.to_domain().spec for effect in self.effects),
        )
        values = len(setup.responses) * len(setup.drives) * setup.analyser.n_lines
        if values > _MOST_VALUES:
            raise InvalidInputError(
                "lines times responses are too many",
                field="n_lines",
                value=values,
                allowed=f"<= {_MOST_VALUES}",
            )
        return setup

    def _drives(self) -> tuple[Dof, ...]:
        if (self.drive is None) == (self.drives is None):
            raise InvalidInputError(
                "a rig drives at one DoF or at several",
                field="drive",
                value="neither given" if self.drive is None else "both given",
                allowed="either drive or drives",
            )
        if self.drive is not None:
            return (Dof.parse(self.drive, field="drive"),)
        return tuple(Dof.parse(text, field="drives") for text in self.drives or ())


class RigOut(EntryOut):
    """A rig as declared, defaults filled in."""

    drive: str
    drives: list[str]
    responses: list[str]
    exciter: dict[str, Any]
    force_transducer: dict[str, Any]
    accelerometers: dict[str, Any]
    analyser: dict[str, Any]
    noise: dict[str, Any]
    effects: list[dict[str, Any]]

    @classmethod
    def of(cls, setup: RigSetup, entry: Entry) -> Self:
        """Return what the contract shows of a rig."""
        return cls(**cls.fields(entry), **setup_out(setup))


def setup_out(setup: RigSetup) -> dict[str, Any]:
    """Return a rig as the contract writes it."""
    return {
        "drive": str(setup.drive),
        "drives": [str(dof) for dof in setup.drives],
        "responses": [str(dof) for dof in setup.responses],
        "exciter": asdict(setup.exciter),
        "force_transducer": asdict(setup.force_transducer),
        "accelerometers": asdict(setup.accelerometers),
        "analyser": asdict(setup.analyser),
        "noise": asdict(setup.noise),
        "effects": [effect_out(spec) for spec in setup.effects],
    }
