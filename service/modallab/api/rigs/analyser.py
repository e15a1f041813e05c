"""Wire types of the analyser's settings."""

from typing import Literal

from modallab.api.wire import Count, Number, Text, Wire
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.excitation import EXCITATIONS

_DEFAULT = Analyser()


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
    bits: Count | None = _DEFAULT.bits
    range_factor: Number = _DEFAULT.range_factor
    excitation: ExcitationIn = ExcitationIn()
    coupling: Literal["dc", "ac"] = _DEFAULT.coupling
    coupling_frequency: Number = _DEFAULT.coupling_frequency
    mass_cancellation: Number = _DEFAULT.mass_cancellation

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
            bits=self.bits,
            range_factor=self.range_factor,
            excitation=self.excitation.to_domain(),
            coupling=self.coupling,
            coupling_frequency=self.coupling_frequency,
            mass_cancellation=self.mass_cancellation,
        )
