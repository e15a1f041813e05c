"""Settings of a round of the search: which candidates are fitted."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting
from modallab.diagnosis.searching.settings import TESTS


@dataclass(frozen=True)
class RoundSettings(Settings):
    """One round of the search."""

    max_fits: int = setting(6, unit="fits", doc="candidates of a round that are fitted", tuned=TESTS)
    max_fits_of_kind: int = setting(3, unit="fits", doc="candidates of one kind among them", tuned=TESTS)
    min_fits: int = setting(
        3,
        unit="fits",
        doc="candidates that are fitted in any case",
        derived="a result shows the rivals of its explanation",
    )
    kinds_at_neighbours: int = setting(
        4,
        unit="kinds",
        doc="kinds of effects that are fitted at adjoining places too",
        tuned="members of a fine, lightly damped bar: with 2, one of seven is never fitted",
    )
    competitive_cost: float = setting(
        10.0,
        doc="cost over that of the best effect above which another is neither fitted nor followed",
        tuned=TESTS,
    )
    limiting_cost: float = setting(
        100.0,
        doc="chi-square after a few steps, over the best fit's, above which a fit is given up",
        tuned="a spring that a heavy oscillator below the band imitates: 50 times, and it explains the test",
    )
    budget_share: float = setting(
        0.5,
        doc="share of the remaining predictions that the fits of a round may take",
        derived="of a pair the second round costs as much as the first",
    )
    optional_cost: float = setting(
        2.0,
        doc="cost over that of the best fit above which no optional parameters are fitted",
        tuned="a foreign test of a viscous absorber: the damper of the right one closes a factor of 2.7",
    )
    declared_cost: float = setting(
        2.0,
        doc="chi-square over that of the best fit above which none is begun at the declared values too",
        tuned="a mass on a student's frame: 1.1 times that of the best wrong place, and 1/46 from there",
    )
    refitted_cost: float = setting(
        2.0,
        doc="chi-square over that of the best fit, up to which other tolerances repeat a fit in full",
        tuned="a rotational spring at the drive beside a bending stinger: given up after a few steps",
    )
    linear_share: float = setting(
        0.6, doc="share of a round's progress before nonlinear forces", tuned="CPU time of simulated tests"
    )
    declared_starts: int = setting(
        2,
        unit="fits",
        doc="fits in a row that a start at the declared values does not improve, after which none is tried",
        tuned="the mass of `declared_cost` is second; of a model a little wrong none of ten was improved",
    )
    hopeless_cost: float = setting(
        2.0,
        doc="cost of a coarse fit, over that of an explanation that leaves noise, above which none is fitted",
        tuned=TESTS,
    )
    same_cost: float = setting(
        0.01,
        doc="relative difference in cost within which two fits of an effect end in the same minimum",
        derived="ends of fits far from the data differ by less than a hundredth of the cost",
    )


@dataclass(frozen=True)
class ResonanceSettings(Settings):
    """Sizes of an effect on the exciter that are compared with the data at all lines."""

    largest_ratio: float = setting(
        1.35,
        doc="largest ratio of a size to that of the fit",
        derived="16 % of the frequency: coarse lines are no farther apart from the sixth of them on",
    )
    n_values: int = setting(
        61,
        unit="sizes",
        doc="sizes of the effect",
        derived="steps of 0.5 % of the frequency, a quarter of a bandwidth at a loss factor of 0.02",
    )


@dataclass(frozen=True)
class SingleLineSettings(Settings):
    """Effects that show in single lines."""

    least_excess: float = setting(
        6.0,
        unit="standard deviations",
        doc="excess of an incoherent spectrum at a line over all beside it from which an effect shows",
        derived="beyond chance among a thousand lines and a dozen channels (4.5)",
    )
    reach: int = setting(
        2, unit="lines", doc="lines on either side that show the effect too", derived="of windows in use"
    )
    lines_beside: int = setting(
        6, unit="lines", doc="further lines on either side", derived="a resonance is as wide as some of them"
    )
    few_channels: int = setting(
        2, unit="channels", doc="channels up to which each is taken for itself", tuned=TESTS
    )


@dataclass(frozen=True)
class NarrowingSettings(Settings):
    """Smaller effects in bursts, whose random errors are narrower."""

    ratio: float = setting(
        0.5,
        doc="size of an effect over that of the step before",
        derived="an octave: errors are known to that",
    )
    max_steps: int = setting(
        8, unit="steps", doc="largest number of steps", derived="two decades, as the grid of sizes is wide"
    )


ROUND = RoundSettings()
RESONANCE = ResonanceSettings()
SINGLE_LINES = SingleLineSettings()
NARROWING = NarrowingSettings()
