"""Wire types of rigs; parts left out are ideal."""

from typing import Annotated

from pydantic import Field

from modallab.api.limits import REQUEST
from modallab.api.rigs.analyser import AnalyserIn
from modallab.api.rigs.hardware import (
    AccelerometersIn,
    ExciterIn,
    ForceTransducerIn,
    NoiseIn,
    StingerIn,
    SuspensionIn,
)
from modallab.api.wire import Effects, Translation, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.rig.compatibility import check_compatible
from modallab.rig.setup import RigSetup
from modallab.rig.suspension import Suspension

_USUAL = {"shaker": "periodic_random", "hammer": "impact"}  # excitations, where none is named


class RigIn(Wire):
    """The log book of a test."""

    drive: Translation | None = None
    """degree of freedom of the force, a translation; give this or `drives`"""
    drives: Annotated[list[Translation], Field(min_length=1, max_length=100)] | None = None
    """degrees of freedom of several forces, or of the blows of a roving hammer"""
    responses: Annotated[list[Translation], Field(min_length=1, max_length=2000)]
    """degrees of freedom of the accelerometers"""
    exciter: ExciterIn | None = None
    """exciter; null: an ideal shaker"""
    stinger: StingerIn | None = None
    """stinger; null: none"""
    force_transducer: ForceTransducerIn | None = None
    """force transducer; null: without mass and rigid"""
    accelerometers: AccelerometersIn | None = None
    """accelerometers; null: without mass and ideal"""
    analyser: AnalyserIn | None = None
    """settings of the FFT analyser; null: 800 Hz, 401 lines, H1"""
    noise: NoiseIn | None = None
    """noise of the channels; null: unknown, of a simulated test none"""
    suspension: SuspensionIn | None = None
    """suspension of the structure; null: it floats"""
    effects: Effects = ()
    """effects of the rig that have no field here"""

    def to_domain(self) -> RigSetup:
        """Return the rig; `InvalidInputError` where it makes no sense or asks for too much."""
        exciter = (self.exciter or ExciterIn()).to_domain()
        setup = RigSetup(
            drives=self._drives(),
            responses=tuple(Dof.parse(text, field="responses") for text in self.responses),
            exciter=exciter,
            stinger=self.stinger.to_domain() if self.stinger else None,
            force_transducer=(self.force_transducer or ForceTransducerIn()).to_domain(),
            accelerometers=(self.accelerometers or AccelerometersIn()).to_domain(),
            analyser=(self.analyser or AnalyserIn()).to_domain(_USUAL[exciter.kind]),
            noise=(self.noise or NoiseIn()).to_domain(),
            suspension=self.suspension.to_domain() if self.suspension else Suspension(),
            effects=tuple(effect.to_domain().spec for effect in self.effects),
        )
        check_compatible(setup)
        setup.check_noise_channels()
        values = len(setup.responses) * len(setup.drives) * setup.analyser.n_lines
        if values > REQUEST.rig_values:
            raise InvalidInputError(
                "lines times responses are too many",
                field="n_lines",
                value=values,
                allowed=bounds(maximum=REQUEST.rig_values),
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
