"""Settings of jobs: polling, attempts and progress."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class JobSettings(Settings):
    """Polling, retries and progress reports of jobs."""

    polling_interval: float = setting(
        0.1, unit="s", doc="time until a queued job starts", derived="short beside the shortest job"
    )
    max_attempts: int = setting(
        3,
        unit="attempts",
        doc="attempts of a job whose worker process dies",
        derived="a job that kills its process three times would do so again",
    )
    progress_interval: float = setting(
        0.1, unit="s", doc="time between two entries of progress in the book", derived="ten a second are read"
    )
    window_samples: int = setting(
        1024,
        unit="samples",
        doc="samples of a window whose leakage is computed",
        derived="shapes of windows do not depend on it",
    )
    listed_dofs: int = setting(
        20, unit="DoFs", doc="degrees of freedom listed in an error message", derived="length of one line"
    )
    further_tests: int = setting(
        2,
        unit="tests",
        doc="further tests that one diagnosis runs",
        derived="a job takes at most three times as long as one diagnosis",
    )
    diagnosis_share: float = setting(
        0.85,
        doc="share of a round's progress that is the diagnosis; the rest is the further test",
        derived="a diagnosis takes longer than a simulated test; changes the displayed progress only",
    )
    refitted_values: int = setting(
        2_000_000,
        unit="values of FRFs",
        doc="values up to which residuals are fitted again to the modes that a selection leaves",
        derived="a selection answers at once: 1.5 million values take 1.7 s",
    )


JOB = JobSettings()
