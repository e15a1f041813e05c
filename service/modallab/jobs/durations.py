"""Durations of jobs, estimated before they are accepted: on one core, rounded up."""

from collections.abc import Iterable
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError, bounds
from modallab.core.settings import Settings, setting
from modallab.jobs.runner import Lane
from modallab.jobs.settings import JOB
from modallab.rig.acquisition import samples_of
from modallab.rig.effect import Effect, Stage
from modallab.rig.measure import Route
from modallab.rig.setup import RigSetup

_MEASURED = "measured on one core of a server of 2023, rounded up"


@dataclass(frozen=True)
class DurationSettings(Settings):
    """Times that parts of jobs take."""

    sample: float = setting(4e-8, unit="s", doc="sample of a channel of a simulated test", derived=_MEASURED)
    stepped_sample: float = setting(
        1.2e-5, unit="s", doc="sample of a run that is stepped through a nonlinear force", derived=_MEASURED
    )
    solution: tuple[float, float, float] = setting(
        (1e-3, 3e-5, 2e-9),
        unit="s",
        doc="modes of a structure: in all, for each degree of freedom, for each pair of them",
        derived=_MEASURED + ": 42 to 30,000 degrees of freedom",
    )
    extracted_byte: float = setting(
        1e-6, unit="s", doc="byte of a measurement that modes are extracted from", derived=_MEASURED
    )
    solutions_of_diagnosis: int = setting(
        3000, unit="solutions", doc="times that a diagnosis solves for the modes", derived=_MEASURED
    )


DURATION = DurationSettings()


@dataclass(frozen=True)
class Duration:
    """Duration of a job, and the value in its request that it is proportional to."""

    seconds: float
    """s, estimate."""
    field: str
    """Name of the value."""
    value: int
    """The value."""

    @property
    def lane(self) -> Lane:
        """Part of the queue that the job waits in."""
        return Lane.SHORT if self.seconds <= JOB.short_job else Lane.LONG

    def check(self, limit: float) -> None:
        """Raise `InvalidInputError` if the job takes longer than a limit, s."""
        if self.seconds <= limit:
            return
        most = int(self.value * limit / self.seconds)
        raise InvalidInputError(
            f"the job would take {self.seconds:.2g} s by estimate, longer than the {limit:g} s that one may",
            field=self.field,
            value=self.value,
            allowed=bounds(maximum=max(most, 1)) if most else "a smaller test or model",
            estimate=float(f"{self.seconds:.2g}"),
            limit=limit,
        )


def duration_of_measurement(setup: RigSetup, effects: Iterable[Effect], route: Route) -> Duration:
    """Return the duration of a simulated test: averages x samples x channels, or x runs where it is stepped.

    Parameters
    ----------
    effects
        All effects: of the structure, the rig and the test.
    """
    return _duration(setup, route, is_stepped=any(effect.stage is Stage.MOTION for effect in effects))


def duration_of_stepped_measurement(setup: RigSetup, route: Route) -> Duration:
    """Return the duration of a simulated test with a nonlinear force, whether it has one or not."""
    return _duration(setup, route, is_stepped=True)


def _duration(setup: RigSetup, route: Route, *, is_stepped: bool) -> Duration:
    analyser = setup.simulated.analyser
    averages = analyser.simulated_averages
    if route is not Route.SAMPLED:
        return Duration(0.0, "averages", averages)
    runs = setup.simulated.acquisition_runs
    channels = sum(len(run.drives) + len(run.outputs) for run in runs)
    each = DURATION.sample * channels + (DURATION.stepped_sample * len(runs) if is_stepped else 0.0)
    return Duration(averages * samples_of(analyser) * each, "averages", averages)


def duration_of_extraction(weight: float) -> Duration:
    """Return the duration of an extraction of modes from a measurement of so many bytes."""
    return Duration(DURATION.extracted_byte * weight, "measurement_id", int(weight))


def duration_of_solutions(n_dofs: int, n: int, field: str, value: int) -> Duration:
    """Return the duration of a job that solves for the modes of a structure many times.

    Parameters
    ----------
    n
        Times that it does.
    field, value
        What the request says of it.
    """
    fixed, linear, square = DURATION.solution
    return Duration(n * (fixed + linear * n_dofs + square * n_dofs**2), field, value)
