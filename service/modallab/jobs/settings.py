"""Settings of jobs: polling, attempts and progress."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class JobSettings(Settings):
    """Polling, retries and progress reports of jobs."""

    polling_interval: float = setting(
        0.1,
        unit="s",
        doc="time between two looks for queued jobs while something happens",
        derived="short beside the shortest job",
    )
    idle_interval: float = setting(
        5.0,
        unit="s",
        doc="time between two looks for queued jobs while nothing happens",
        derived="a call wakes whoever looks; this finds what a lost call left",
    )
    attentive: float = setting(
        2.0,
        unit="s",
        doc="time after a call in which looks are frequent",
        derived="a place for a job is free some time after the call that tells of it",
    )
    longest_stop: float = setting(
        0.5, unit="s", doc="time until a thread that waits sees that it has to end", derived="of a shutdown"
    )
    longest_end: float = setting(
        20.0,
        unit="s",
        doc="time after which a worker that was asked to end ends whatever is under way",
        derived="it ends within 5 s unless the database is away; what it leaves is taken over",
    )
    max_attempts: int = setting(
        14,
        unit="attempts",
        doc="attempts of a job whose worker process dies",
        derived="an operator's kills do not count as the job's own fault; one that dies of itself ends",
    )
    attempt_backoff: float = setting(
        1.4, doc="ratio of the pauses between attempts", derived="0.1 s first, 21 s in all"
    )
    short_job: float = setting(
        2.0,
        unit="s",
        doc="estimated duration up to which a job is short",
        derived="simulated tests and extractions of a class are, a diagnosis never is",
    )
    short_niceness: int = setting(
        5,
        doc="niceness, over that of the service, of a process that runs a short job",
        derived="where both want the same core, requests get three quarters of it: each takes milliseconds",
    )
    long_niceness: int = setting(
        15,
        doc="niceness, over that of the service, of a process that runs a long job",
        derived="where both want the same core, a short job gets nine tenths of it and the long one goes on",
    )
    latest_jobs: int = setting(
        20, unit="jobs", doc="latest jobs of a kind whose times tell how long one takes", derived="a class's"
    )
    max_restarts: int = setting(
        5,
        unit="restarts",
        doc="restarts of a job that the engine has ended and the book has not",
        derived="faults of the database at its end; not restarts of the service, which are not counted",
    )
    beat_interval: float = setting(
        2.0, unit="s", doc="time between two signs of life of an executor", derived="a row every two seconds"
    )
    idle_beats: int = setting(
        3,
        unit="beats",
        doc="beats between two looks at book and engine while no job is active",
        derived="lost executors are found within 30 s; an idle service takes less than 1 % of a core",
    )
    sweep_interval: float = setting(
        3600.0, unit="s", doc="time between two removals of what is old", derived="short beside a day"
    )
    lost_after: float = setting(
        15.0,
        unit="s",
        doc="time without a sign of life after which an executor is lost",
        derived="several beats, so that a busy machine is not; jobs move within 30 s",
    )
    outage_pause: float = setting(
        0.5, unit="s", doc="first pause before work is tried anew while the database is away", derived="short"
    )
    longest_outage_pause: float = setting(
        5.0, unit="s", doc="longest such pause", derived="work goes on soon after the database is back"
    )
    longest_outage: float = setting(
        600.0, unit="s", doc="time for which work waits for the database", derived="a restart of a server"
    )
    time_limit: float = setting(
        6 * 3600.0,
        unit="s",
        doc="longest time that a worker process has for a job or a share",
        derived="many times the longest job known; what stands still is not waited for any longer",
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
