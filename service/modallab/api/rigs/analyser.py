"""Wire types of the analyser's settings."""

from dataclasses import replace
from typing import Annotated, Literal

from modallab.api.names import EstimatorName, ExcitationKind, WindowName
from modallab.api.schema import Limits, Specified
from modallab.api.wire import Count, Number, Wire
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.settings import ACQUISITION

_DEFAULT = Analyser()
_SPECS = ExcitationSetting.specs()
_Frequency = Annotated[Number, Limits(0.0, 1e6)]


class ExcitationIn(Wire):
    """Signal of the source, its level in N rms over its band, and parameters of a burst or a hammer."""

    kind: ExcitationKind = _DEFAULT.excitation.kind
    """kind of signal; left out: periodic_random, or impact for a hammer"""
    level: Annotated[Number, Specified(_SPECS["level"])] | None = None
    """N, rms of the source over its band; null: unknown"""
    burst: Annotated[Number, Specified(_SPECS["burst"])] = _DEFAULT.excitation.burst
    tip_stiffness: Annotated[Number, Specified(_SPECS["tip_stiffness"])] = _DEFAULT.excitation.tip_stiffness
    hammer_mass: Annotated[Number, Specified(_SPECS["hammer_mass"])] = _DEFAULT.excitation.hammer_mass
    pre_trigger: Annotated[Number, Specified(_SPECS["pre_trigger"])] = _DEFAULT.excitation.pre_trigger
    level_scatter: Annotated[Number, Specified(_SPECS["level_scatter"])] = _DEFAULT.excitation.level_scatter
    place_scatter: Annotated[Number, Specified(_SPECS["place_scatter"])] = _DEFAULT.excitation.place_scatter
    angle_scatter: Annotated[Number, Specified(_SPECS["angle_scatter"])] = _DEFAULT.excitation.angle_scatter

    band: tuple[_Frequency, _Frequency] | None = _DEFAULT.excitation.band
    """Hz, lowest and highest frequency that the source drives; null: the whole band of the analyser"""
    shape: Literal["flat", "unknown"] = _DEFAULT.excitation.shape
    """spectrum of the source over its band; a diagnosis leaves an unknown one free; left out: flat, of a blow
    of which neither level, tip nor mass are stated unknown"""

    def to_domain(self, usual: str) -> ExcitationSetting:
        """Return the excitation, of the `usual` kind where none is given; an unknown kind raises."""
        stated = self.model_fields_set
        kind = self.kind if "kind" in stated else usual
        setting = ExcitationSetting(kind, **self.model_dump(exclude={"kind"}))
        if kind == "impact" and not stated & {"level", "tip_stiffness", "hammer_mass", "shape"}:
            return replace(setting, shape="unknown")
        return setting


UNKNOWN_EXCITATION = ExcitationIn(shape="unknown")


class AnalyserIn(Wire):
    """Settings of the analyser: `n_lines` from `frequency_min` to `frequency_max`, both counted."""

    frequency_min: Annotated[Number, Limits(0.0, 1e6)] = _DEFAULT.frequency_min
    """Hz, frequency of the first line; a multiple of the line spacing wherever records are simulated"""
    frequency_max: Annotated[Number, Limits(1e-3, 1e6)] = _DEFAULT.frequency_max
    """Hz, frequency of the last line, up to which the source drives"""
    n_lines: Annotated[Count, Limits(8, 1_000_000)] = _DEFAULT.n_lines
    """number of lines, the first and the last counted"""
    window: WindowName = _DEFAULT.window
    """window of the records"""
    averages: Annotated[Count, Limits(1, 100_000)] | None = None
    """number of averages; null: unknown, estimated from an uploaded test, 100 of a simulated one"""
    overlap: Annotated[Number, Limits(0.0, 0.9)] = _DEFAULT.overlap
    """1, share of a record that overlaps the one before"""
    estimator: EstimatorName = _DEFAULT.estimator
    """FRF estimator"""
    bits: Annotated[Count, Limits(4, 32)] | None = _DEFAULT.bits
    """resolution of the converter; null: ideal"""
    range_factor: Annotated[Number, Limits(0.5, 100.0)] = _DEFAULT.range_factor
    """1, full scale over the rms of each channel, where there are bits"""
    excitation: ExcitationIn | None = None
    """signal of the source; null: its spectrum is unknown, of a simulated test flat, 1 N"""
    coupling: Literal["dc", "ac"] = _DEFAULT.coupling
    """coupling of all inputs"""
    coupling_frequency: Annotated[Number, Limits(0.0, 1e4)] = _DEFAULT.coupling_frequency
    """Hz, high-pass corner (3 dB) of AC coupling"""
    mass_cancellation: Annotated[Number, Limits(0.0, 5.0)] = _DEFAULT.mass_cancellation
    """kg, mass times the drive point acceleration that is subtracted from the force"""
    window_end: Annotated[Number, Limits(*ACQUISITION.window_end_bounds)] = _DEFAULT.window_end
    """1, height of an exponential window at the end of the record"""
    force_width: Annotated[Number, Limits(1e-3, 0.999)] = _DEFAULT.force_width
    """1, share of the record that a force window passes"""

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
            frequency_min=self.frequency_min,
            frequency_max=self.frequency_max,
            n_lines=self.n_lines,
            window=self.window,
            averages=self.averages,
            overlap=self.overlap,
            estimator=self.estimator,
            bits=self.bits,
            range_factor=self.range_factor,
            excitation=(self.excitation or UNKNOWN_EXCITATION).to_domain(usual),
            coupling=self.coupling,
            coupling_frequency=self.coupling_frequency,
            mass_cancellation=self.mass_cancellation,
            window_end=self.window_end,
            force_width=self.force_width,
        )
