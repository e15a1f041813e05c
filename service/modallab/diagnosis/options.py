"""Options of a diagnosis."""

from dataclasses import dataclass
from typing import Any

from modallab.core.line_options import LineOptions
from modallab.core.options import Options, option
from modallab.diagnosis.optimisation.tolerances import NO_TOLERANCES, TolerancePreset, Tolerances


@dataclass(frozen=True)
class HoldOut(Options):
    """FRFs kept out of every fit; responses that were not measured are predicted."""

    fraction: float = option(0.25, unit="1", doc="share of the measured FRFs that is kept out, 0 to 0.5")
    dofs: tuple[str, ...] = option(
        (),
        doc="responses that are kept out in any case, as `node:direction`; predicted where not measured",
        max_items=200,
    )


@dataclass(frozen=True)
class DiagnosisOptions(LineOptions):
    """How a diagnosis is made."""

    suspects: tuple[str, ...] | None = option(
        None, doc="kinds of effects to look for", min_items=1, max_items=100, null_name="all"
    )
    hold_out: HoldOut = option(HoldOut(), doc="FRFs kept out of every fit")
    tolerances: Tolerances | TolerancePreset | None = option(
        None,
        doc="what may differ a little and is no missing effect, one standard deviation each, or a preset's "
        "name; left out: `none` for a simulated test, `ordinary` for an uploaded one that is not explained "
        "without",
    )
    act: bool = option(False, doc="run the proposed next tests, where the rig is a simulated one")
    noise_floor: float | None = option(
        None,
        unit="1",
        exclusive_minimum=0.0,
        upper=1.0,
        doc="relative random error of every FRF, of its median where it is below that; beside what coherence "
        "and averages tell, alone where there is no coherence",
    )
    max_effects: int = option(4, unit="1", lower=1, upper=8, doc="largest number of effects added")
    seed: int = option(
        0, unit="1", lower=0, upper=2**63 - 1, doc="seed of the draw of the FRFs that are kept out"
    )

    @property
    def stated_tolerances(self) -> Tolerances:
        """The tolerances that are stated, by name or one by one."""
        if isinstance(self.tolerances, TolerancePreset):
            return Tolerances.preset(self.tolerances)
        return self.tolerances or NO_TOLERANCES

    @property
    def request(self) -> dict[str, Any]:
        """The options beside the seed, as the body of a request has them."""
        stated: dict[str, Any] = {
            "suspects": "all" if self.suspects is None else list(self.suspects),
            "hold_out": {"fraction": self.hold_out.fraction, "dofs": list(self.hold_out.dofs)},
            "max_effects": self.max_effects,
        }
        for name, bands in (("bands", self.bands), ("exclude", self.exclude)):
            if bands:
                stated[name] = [list(band) for band in bands]
        if isinstance(self.tolerances, Tolerances):
            stated["tolerances"] = self.tolerances.stated
        elif self.tolerances is not None:
            stated["tolerances"] = self.tolerances.value
        return stated if self.noise_floor is None else stated | {"noise_floor": self.noise_floor}
