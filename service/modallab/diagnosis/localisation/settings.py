"""Settings of the localisation of disagreements between measurement and model."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class EvidenceSettings(Settings):
    """Estimation of frequency shifts from the FRFs, for the choice of suspects."""

    largest_shift: float = setting(
        0.1,
        doc="largest relative frequency shift that is sought by the shape of a resonance",
        tuned="simulated tests of the suite",
    )
    n_shifts: int = setting(
        81,
        unit="shifts",
        doc="grid points from minus to plus the largest shift",
        derived="steps of 0.25 %, about a line of a test with 400 lines",
    )
    difference_step: float = setting(
        1e-5,
        doc="relative frequency shift of the finite difference",
        derived="far above rounding and far below the width of any resonance",
    )
    resonance_reach: float = setting(
        0.15,
        doc="share of a mode's frequency, to either side, in which its resonance is read",
        tuned="simulated tests of the suite",
    )
    least_reach: int = setting(
        4, unit="lines", doc="least reach to either side", tuned="simulated tests of the suite"
    )
    fewest_lines: int = setting(
        5, unit="lines", doc="lines below which no shift is read", tuned="simulated tests of the suite"
    )


@dataclass(frozen=True)
class LocalisationSettings(Settings):
    """Decision which bands, responses, modes and patterns are named."""

    disagreement: float = setting(
        3.0,
        doc="mean squared residual above which a band or a response is named",
        tuned="simulated tests of the suite",
    )
    part_significance: float = setting(
        5.0,
        unit="standard errors",
        doc="excess of a part's gap over 1 from which on the part disagrees",
        derived="5 sigma: chance alone exceeds it once in 3.5 million",
    )
    band_end: float = setting(
        0.25,
        doc="share of the band that counts as its low or high end",
        derived="quarters of the band, as `GapPattern` defines its ends",
    )
    minor_excess: float = setting(
        0.1,
        doc="share of the worst part's excess below which the FRFs do not carry the gap",
        tuned="simulated tests of the suite",
    )
    agreeing_excess: float = setting(
        0.05,
        doc="share of the worst response's excess below which another response agrees",
        tuned="simulated tests of the suite",
    )
    band_level: float = setting(
        0.1,
        doc="share of the worst line's mean squared residual above which a line belongs to a band",
        tuned="simulated tests of the suite",
    )
    response_level: float = setting(
        0.5,
        doc="share of the worst response's mean squared residual above which a response is named",
        tuned="simulated tests of the suite",
    )
    band_separation: int = setting(
        3,
        unit="lines",
        doc="largest distance of lines within one band",
        derived="length of the moving average over lines",
    )
    mode_margin: float = setting(
        2.0,
        unit="lines",
        doc="distance from a band within which a mode belongs to it",
        tuned="simulated tests of the suite",
    )
    max_bands: int = setting(20, unit="bands", doc="bands in a result", derived="size of a reply")
    max_modes: int = setting(
        8,
        unit="modes",
        doc="modes whose shifts are estimated",
        derived="computing time: each mode takes predictions of its own",
    )


@dataclass(frozen=True)
class ModeShiftSettings(Settings):
    """Fit of one pole near a resonance (Sanathanan and Koerner iteration)."""

    reach: float = setting(
        3.0,
        unit="half-power bandwidths",
        doc="distance from the resonance, to either side, of the fitted lines",
        tuned="simulated tests of the suite",
    )
    fewest_lines: int = setting(
        4,
        unit="lines",
        doc="least number of fitted lines to either side",
        derived="7 lines: twice the 3 complex unknowns and one",
    )
    model_error: float = setting(
        3e-4,
        doc="relative error of an FRF represented as one mode and a straight line",
        tuned="simulated tests of the suite",
    )
    iterations: int = setting(
        4,
        unit="iterations",
        doc="least-squares solutions, each weighted by the previous pole",
        derived="convergence order of the iteration from a known start",
    )
    largest_shift: float = setting(
        0.05,
        doc="relative distance from the resonance beyond which a pole is spurious",
        tuned="simulated tests of the suite",
    )
    least_loss_factor: float = setting(
        1e-6, doc="least loss factor of the starting pole", derived="keeps the first weights finite"
    )


@dataclass(frozen=True)
class ChannelErrorSettings(Settings):
    """Attribution of a response's misfit to one channel error."""

    explained_share: float = setting(
        0.9,
        doc="share of a response's gap above 1 that the error must account for",
        tuned="simulated tests of the suite",
    )
    disagreement: float = setting(
        3.0,
        doc="gap of a response above which its error is sought",
        tuned="simulated tests of the suite",
    )


@dataclass(frozen=True)
class StatementSettings(Settings):
    """Choice of the statements on where a gap lies."""

    shift_significance: float = setting(
        4.0,
        unit="standard errors",
        doc="size of a mode's shift above which it is stated",
        derived="4 sigma: chance alone exceeds it once in 16,000",
    )
    smallest_shift: float = setting(
        1e-5,
        doc="relative shift below which nothing is stated",
        derived="smaller shifts have no practical meaning",
    )
    common_spread: float = setting(
        0.1,
        doc="range of the shifts of all modes over their mean below which they are one shift",
        tuned="simulated tests of the suite",
    )
    band_share: float = setting(
        0.95,
        doc="share of the gap's excess inside the band that a statement names",
        tuned="simulated tests of the suite",
    )
    max_items: int = setting(
        8, unit="items", doc="bands, modes or responses in a statement", derived="legibility"
    )


EVIDENCE = EvidenceSettings()
LOCALISATION = LocalisationSettings()
MODE_SHIFTS = ModeShiftSettings()
CHANNEL_ERRORS = ChannelErrorSettings()
STATEMENTS = StatementSettings()
