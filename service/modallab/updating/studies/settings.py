"""Settings of studies of updating methods."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class StudySettings(Settings):
    """Studies of a method on noisy modes."""

    max_runs: int = setting(
        2000,
        unit="updates",
        doc="updates of one study",
        derived="bounds the work of one job",
    )
    error_quantile: float = setting(
        0.9,
        doc="quantile beside the median in the table of a study",
        derived="one run of ten is worse",
    )


STUDY = StudySettings()
