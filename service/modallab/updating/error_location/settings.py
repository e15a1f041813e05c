"""Settings of error location by one linear step."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class ErrorLocationSettings(Settings):
    """Zhang's two methods."""

    min_weight: float = setting(
        0.1,
        doc="weight over the largest one below which a large change means low sensitivity, no error",
        tuned="three cases of the 1992 thesis in tests/published",
    )
    min_reduction: float = setting(
        0.05,
        doc="relative reduction of the residual below which no further coefficient is suspected",
        tuned="three cases of the 1992 thesis in tests/published",
    )
    rounding_difference: float = setting(
        1e-6,
        doc="balanced difference made by rounding of eigenvalues",
        tuned="eigenvalues of the models of the suite",
    )
    min_independent_share: float = setting(
        1e-6,
        doc="share of a column outside the span of the selected ones below which it is dependent",
        derived="rounding of orthogonalised columns",
    )


ERROR_LOCATION = ErrorLocationSettings()
