"""Wire types of the analyser's settings."""

from typing import Literal

from modallab.api.wire import Count, Number, Text, Wire
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.rig.analyser import Analyser, ExcitationSetting

_DEFAULT = Analyser()


class ExcitationIn(Wire):
    """The signal of the source, N rms from 0 Hz to the top of the band; what a burst or a hammer is like."""

    kind: Text = _DEFAULT.excitation.kind
    level: Number = _DEFAULT.excitation.level
    burst: Number = _DEFAULT.excitation.burst
    tip_stiffness: Number = _DEFAULT.excitation.tip_stiffness
    hammer_mass: Number = _DEFAULT.excitation.hammer_mass
    pre_trigger: Number = _DEFAULT.excitation.pre_trigger
    level_scatter: Number = _DEFAULT.excitation.level_scatter
    place_scatter: Number = _DEFAULT.excitation.place_scatter
    angle_scatter: Number = _DEFAULT.excitation.angle_scatter

    def to_domain(self, usual: str) -> ExcitationSetting:
        """Return the excitation, of the `usual` kind where none is given; an unknown kind raises."""
        kind = self.kind if "kind" in self.model_fields_set else usual
        return ExcitationSetting(kind, **self.model_dump(exclude={"kind"}))


class AnalyserIn(Wire):
    """Settings of the analyser; `n_lines` counts 0 Hz."""

    frequency_max: Number = _DEFAULT.frequency_max
    n_lines: Count = _DEFAULT.n_lines
    window: Text = _DEFAULT.window
    averages: Count = _DEFAULT.averages
    overlap: Number = _DEFAULT.overlap
    estimator: Text = _DEFAULT.estimator
    bits: Count | None = _DEFAULT.bits
    range_factor: Number = _DEFAULT.range_factor
    excitation: ExcitationIn = ExcitationIn()
    coupling: Literal["dc", "ac"] = _DEFAULT.coupling
    coupling_frequency: Number = _DEFAULT.coupling_frequency
    mass_cancellation: Number = _DEFAULT.mass_cancellation
    window_end: Number = _DEFAULT.window_end
    force_width: Number = _DEFAULT.force_width

    def to_domain(self, usual: str = _DEFAULT.excitation.kind) -> Analyser:
        """Return the analyser; unknown names raise.

        Parameters
        ----------
        usual
            Kind of excitation where none is given.
        """
        WINDOWS[self.window]
        ESTIMATORS[self.estimator]
        return Analyser(
            frequency_max=self.frequency_max,
            n_lines=self.n_lines,
            window=self.window,
            averages=self.averages,
            overlap=self.overlap,
            estimator=self.estimator,
            bits=self.bits,
            range_factor=self.range_factor,
            excitation=self.excitation.to_domain(usual),
            coupling=self.coupling,
            coupling_frequency=self.coupling_frequency,
            mass_cancellation=self.mass_cancellation,
            window_end=self.window_end,
            force_width=self.force_width,
        )
