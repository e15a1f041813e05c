"""Plan of a study: method, noise levels, divisions into macro elements and seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.error_location.method import LOCATORS
from modallab.updating.method import UPDATERS
from modallab.updating.options import LocationOptions, UpdateOptions
from modallab.updating.parameterisation import Parameterisation, Part
from modallab.updating.studies.settings import STUDY

# The levels of the 1992 thesis, section 4.2.1: relative errors, evenly drawn, of eigenvalues and shapes.
NOISE_LEVELS: Mapping[str, ModeNoise] = {
    "NL1": ModeNoise(),
    "NL2": ModeNoise(eigenvalue=0.002, eigenvector=0.02),
    "NL3": ModeNoise(eigenvalue=0.005, eigenvector=0.05),
    "NL4": ModeNoise(eigenvalue=0.01, eigenvector=0.10),
}


@dataclass(frozen=True)
class Level:
    """Noise level of the modes."""

    name: str
    """Name of the noise level."""
    noise: ModeNoise
    """Errors of the modes."""


@dataclass(frozen=True)
class Division:
    """Division of members into macro elements."""

    name: str
    """Name of the division."""
    parameterisation: Parameterisation
    """Coefficients that are free to change, with their bounds."""


@dataclass(frozen=True)
class StudyPlan:
    """Updates of a study: one for each noise level, division and seed.

    A seed gives the same errors at every level, apart from their size, and in every division.

    Raises
    ------
    InvalidInputError
        If the method neither corrects coefficients nor locates by them, a name or a seed comes twice, the
        divisions are of different parts, or there are no runs or too many.
    """

    method: str
    """Name of the updating method."""
    levels: tuple[Level, ...]
    """Noise levels of the modes."""
    divisions: tuple[Division, ...]
    """Divisions into macro elements."""
    seeds: tuple[int, ...]
    """Seeds of the noise."""
    count: int
    """Number of measured modes."""
    dofs: tuple[Dof, ...]
    """DoFs of the measured shapes."""
    options: UpdateOptions | LocationOptions
    """Options of the method."""

    def __post_init__(self) -> None:
        check_method(self.method)
        _check_unique("levels", [level.name for level in self.levels])
        _check_unique("divisions", [division.name for division in self.divisions])
        _check_unique("seeds", self.seeds)
        if not 1 <= self.n_runs <= STUDY.max_runs:
            raise InvalidInputError(
                "a study is levels x divisions x seeds of updates",
                field="seeds",
                value=self.n_runs,
                allowed=bounds(1, STUDY.max_runs),
            )
        if len({frozenset(division.parameterisation.parts) for division in self.divisions}) > 1:
            raise InvalidInputError(
                "all divisions of a study correct the same parts",
                field="divisions",
                value=len(self.divisions),
                allowed="equal parts",
            )

    @property
    def n_runs(self) -> int:
        """Number of updates."""
        return len(self.levels) * len(self.divisions) * len(self.seeds)

    @property
    def parts(self) -> tuple[Part, ...]:
        """Parts that are corrected."""
        return self.divisions[0].parameterisation.parts

    def run(self, index: int) -> tuple[Level, Division, int]:
        """Return level, division and seed of a run; seeds vary fastest."""
        level_and_division, seed = divmod(index, len(self.seeds))
        level, division = divmod(level_and_division, len(self.divisions))
        return self.levels[level], self.divisions[division], self.seeds[seed]


def check_method(name: str) -> None:
    """Raise `InvalidInputError` unless a method of that name corrects coefficients or locates by them."""
    if name not in UPDATERS and name not in LOCATORS:
        raise InvalidInputError(
            f"no method called {name!r} corrects coefficients or locates by them",
            field="method",
            value=name,
            allowed=sorted([*UPDATERS, *LOCATORS]),
        )


def _check_unique(field: str, values: Sequence[str | int]) -> None:
    duplicates = [value for i, value in enumerate(values) if value in values[:i]]
    if duplicates:
        raise InvalidInputError(
            f"{duplicates[0]} comes twice in {field}", field=field, value=duplicates[0], allowed="each once"
        )
