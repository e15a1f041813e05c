"""Settings of updating on frequency responses."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class ResponseErrorSettings(Settings):
    """Random errors of measured responses."""

    model_error: float = setting(
        1e-6,
        doc="relative error of the model's own responses, a floor under every random error",
        tuned="receptances of the models of the suite",
    )
    min_coherence: float = setting(
        1e-6,
        doc="coherence below which there is no response",
        derived="far below that of white noise with 100 averages, 0.01",
    )
    max_error: float = setting(
        0.5,
        doc="relative random error from which responses are left out",
        derived="the logarithm is far from normal there",
    )
    unknown_averages: float = setting(
        2,
        unit="averages",
        doc="averages up to which coherence says nothing of random errors",
        derived="1992 thesis, eq. [5.16]: n_d - 2 degrees of freedom",
    )


RESPONSE_ERRORS = ResponseErrorSettings()


@dataclass(frozen=True)
class ResponsePathSettings(Settings):
    """Path from wavefield reconstruction to logarithmic ratios."""

    error_factors: tuple[float, ...] = setting(
        (1.0, 3.0),
        doc="assumed model error over the one that explains the misfit, path by path",
        tuned="first ten patterns of the bay: the second path takes smaller steps",
    )
    max_steps: tuple[int, ...] = setting(
        (12, 30),
        unit="steps",
        doc="steps of wavefield reconstruction, path by path",
        tuned="first ten patterns of the bay",
    )
    min_model_error: float = setting(
        1e-5,
        doc="share of its stiffness that a model is wrong by where logarithmic ratios take over",
        tuned="test_correct.py passes with 1e-7 to 1e-3",
    )
    coarse_numbers: int = setting(
        4_000,
        unit="real numbers",
        doc="measured numbers of the steps of wavefield reconstruction",
        tuned="times of updates of the bay",
    )
    max_numbers: int = setting(
        40_000,
        unit="real numbers",
        doc="measured numbers that coefficients are fitted to; further lines are held out",
        derived="40,000 by 100 doubles are 32 MB",
    )
    max_growth: float = setting(
        1.5,
        doc="mean square after a step over the one before that is accepted",
        tuned="test_correct.py passes with 1 to 6",
    )
    accepted_mean_square: float = setting(
        2.0,
        doc="mean square after a step that is always accepted",
        derived="near the 1 of random errors alone",
    )
    explained_mean_square: float = setting(
        4.0,
        doc="mean square beyond which a second path is tried and the misfit is reported",
        derived="twice the random error",
    )
    coarse_block_rows: int = setting(
        60,
        unit="rows",
        doc="rows of a block of one error variance in wavefield reconstruction",
        derived="few lines, as those near a resonance are not linear",
    )
    block_rows: int = setting(
        300,
        unit="rows",
        doc="rows of a block of one error variance of logarithmic ratios",
        derived="chance moves a variance of 300 rows by 8 %",
    )
    zero_response_error: float = setting(
        1e-3,
        doc="error of a response that hardly moves, over the mean size and relative error of its line",
        tuned="test_correct.py and test_fields.py pass with 1e-5 to 1e-2; test_rows.py states the value",
    )
    model_error_range: tuple[float, float] = setting(
        (1e-6, 10.0),
        doc="least and largest assumed model error",
        derived="a tenth of `min_model_error`, and a model with nothing right",
    )
    field_numbers: int = setting(
        4_000_000,
        unit="complex numbers",
        doc="displacement field held in memory at a time",
        derived="64 MB",
    )


RESPONSE_PATH = ResponsePathSettings()
