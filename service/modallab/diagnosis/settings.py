"""Settings of a diagnosis as a whole."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class DiagnosisSettings(Settings):
    """Choice of suspects, and the size and probabilities of a result."""

    least_suspicion: float = setting(
        0.01,
        doc="suspicion below which a kind of effect is omitted unless the user names it",
        tuned="simulated tests of the suite",
    )
    deviation_probability: float = setting(
        1e-3,
        doc="probability by chance of deviations as large, or as small, below which an effect is likelier",
        derived="3 sigma: one model in a thousand is searched in vain",
    )
    determined_error: float = setting(
        0.3,
        unit="standard deviations of the tolerance",
        doc="standard error below which the data determine a deviation",
        derived="a deviation of one standard deviation is then three standard errors",
    )
    negligible_deviation: float = setting(
        0.1,
        unit="standard deviations of the tolerance",
        doc="root mean square, beside their errors, below which deviations show an exact model",
        derived="a tenth of what is assumed; models whose errors are half as large are searched in vain",
    )
    max_equivalent_effects: int = setting(
        3, unit="effects", doc="equivalent effects listed with a step", derived="legibility"
    )
    incomplete_probability: float = setting(
        0.5,
        doc="factor of the probability of an effect if the diagnosis leaves a gap unexplained",
        tuned="blind trial of single effects, pairs and causes outside the catalogue: of 14 diagnoses that "
        "left a gap, 7 named an effect that was present",
    )
    much_nearer: float = setting(
        0.6,
        doc="chi-square under assumed tolerances over that under stated ones, below which they come first",
        derived="about a half: the assumed ones explain more than they leave",
    )
    partial_excess: float = setting(
        0.01,
        doc="excess of the gap over 1 with an effect, over that without, up to which it explains a part",
        tuned="blind trial of causes outside the catalogue: others close nine tenths of the gap",
    )
    partial_probability: float = setting(
        0.7,
        doc="factor of the probability of an effect if the diagnosis explains a part",
        derived="between 1 of an explanation and the factor of an unexplained gap; few cases are known yet",
    )
    detection_margin: float = setting(
        2.0,
        unit="standard deviations",
        doc="distance of a detection limit from what is detected in half of all tests",
        derived="detected in 98 of 100",
    )
    detection_evaluations: int = setting(
        2,
        unit="evaluations",
        doc="predictions of a detection limit, each nearer to it",
        derived="the second is near the limit; small effects are linear",
    )
    detection_bisections: int = setting(
        6,
        unit="bisections",
        doc="steps to the amount at which bounded nuisance parameters hide an effect no more",
        derived="between limits a factor of a thousand apart, to 11 %",
    )
    detection_step: float = setting(
        1.0,
        unit="standard deviations",
        doc="largest change of all residuals together from which a detection limit is taken to first order",
        derived="the curvature of a change of one standard deviation is small beside it",
    )
    far_less: float = setting(
        0.5,
        doc="excess over random error, over that of another explanation, below which it is far less",
        derived="half: effects that imitate what another explanation has come nearer to it",
    )


DIAGNOSIS = DiagnosisSettings()
