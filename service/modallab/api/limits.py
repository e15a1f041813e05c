"""Limits of requests and replies of the service, beyond those that a request's schema states."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class RequestLimits(Settings):
    """Largest requests that are answered, or queued as jobs."""

    integer: int = setting(
        2**31,
        doc="largest magnitude of an integer without bounds of its own",
        derived="signed 32-bit integer",
    )
    real: float = setting(
        1e30,
        doc="largest magnitude of a number",
        derived="a larger number has no meaning in any unit used here and would overflow in a product",
    )
    described_items: int = setting(
        2000,
        unit="nodes or members",
        doc="items of a structure that is described item by item",
        derived="larger structures come from the catalogue or from files",
    )
    mesh_groups: int = setting(
        1000,
        unit="groups",
        doc="groups that the description of a mesh names",
        derived="far more groups than a mesh names",
    )
    plate_elements: int = setting(
        40_000,
        unit="elements",
        doc="elements of a plate from the catalogue",
        derived="about 120,000 degrees of freedom: modes of more take longer than a request may",
    )
    rig_values: int = setting(
        20_000_000,
        unit="lines x FRFs",
        doc="FRF values of a test with this rig, measured elsewhere",
        derived="a file of the largest upload holds fewer",
    )
    test_values: int = setting(
        2_000_000,
        unit="lines x FRFs",
        doc="FRF values of one simulated test, lines from 0 Hz on",
        derived="its arrays take some hundred megabytes while they are made",
    )
    correlation_values: int = setting(
        2_000_000,
        unit="lines x FRFs",
        doc="measured FRF values that are correlated with a model within a request",
        derived="the request waits for the result; as many values as one test has at most",
    )
    transformation_values: int = setting(
        2_000_000,
        unit="DoFs x masters",
        doc="entries of the transformation of a reduction",
        derived="memory: 16 MB in double precision",
    )
    structure_frf_values: int = setting(
        200_000, unit="lines x responses", doc="values of exact FRFs", derived="memory: 3 MB"
    )
    structure_frf_dofs: int = setting(
        1_000,
        unit="DoFs",
        doc="degrees of freedom of a structure whose exact FRFs are asked for",
        derived="the structure is solved at every line while the request waits",
    )
    study_coefficients: int = setting(
        2_000_000,
        unit="runs x coefficients",
        doc="coefficients of all runs of a study",
        derived="memory: 16 MB",
    )
    follow_ups: int = setting(
        8, unit="tests", doc="follow-up tests of a diagnosis", derived="each takes as long as the first test"
    )


@dataclass(frozen=True)
class ReplyLimits(Settings):
    """Largest replies, and what errors list."""

    json_array_values: int = setting(
        500_000,
        unit="numbers",
        doc="numbers of arrays in JSON; more are sent as npz only",
        derived="encoding more takes longer than a second",
    )
    json_curve_values: int = setting(
        50_000,
        unit="numbers",
        doc="numbers of thinned curves in JSON",
        derived="encoding more costs a hundred times what npz does",
    )
    plot_rows: int = setting(
        40,
        unit="rows",
        doc="lines, or rows of a surface, in the plot data of a fit",
        derived="more lines hide each other in a plot",
    )
    reduced_modes: int = setting(
        10,
        unit="modes",
        doc="elastic modes of the full model that a reduced model is compared with",
        derived="a reduction is meant for the lowest modes",
    )
    value_characters: int = setting(
        200, unit="characters", doc="characters of a refused value in an error", derived="two lines of text"
    )
    faults: int = setting(20, unit="faults", doc="faults listed in an error", derived="one screen of text")


@dataclass(frozen=True)
class JobStreamSettings(Settings):
    """Timing of the event stream of a job."""

    polling_interval: float = setting(
        0.1, unit="s", doc="time between two looks at a job", derived="as often as progress is written"
    )
    longest_interval: float = setting(
        1.0,
        unit="s",
        doc="longest time between two looks at a job that waits",
        derived="jobs of 0.1 s pass it",
    )
    keep_alive: float = setting(
        15.0,
        unit="s",
        doc="silence after which a comment is sent",
        derived="shorter than the silence after which proxies close a stream",
    )
    verification_interval: float = setting(
        5.0,
        unit="s",
        doc="time between two looks at the key, or the session, that opened a stream",
        derived="a look at a key for fifty at the job; what is revoked ends while one waits for it",
    )
    retry_after: int = setting(
        5, unit="s", doc="`Retry-After` of a full queue", derived="about the length of a short job"
    )
    retry_after_removal: int = setting(
        60,
        unit="s",
        doc="`Retry-After` where as much is stored as may be",
        derived="somebody has to remove something; longer than a client waits of itself",
    )


@dataclass(frozen=True)
class ReadinessSettings(Settings):
    """What the service needs to work, and how often a lack of it is told."""

    least_room: int = setting(
        200_000_000,
        unit="B",
        doc="free room on the disk below which the service is not ready",
        derived="the largest upload, see `upload_limit`",
    )
    repeated_warning: float = setting(
        60.0, unit="s", doc="time between two warnings of one fault", derived="a log that can be read"
    )


REQUEST = RequestLimits()
REPLY = ReplyLimits()
JOB_STREAM = JobStreamSettings()
READINESS = ReadinessSettings()
