"""Request of a study."""

from typing import Annotated

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.derived import OptionsByMethod
from modallab.api.limits import REQUEST
from modallab.api.modal_models.schemas import Dofs, ModeNoiseIn, distinct
from modallab.api.schema import NamedByPattern, OneOf
from modallab.api.updates.parameterisation import Macros, ParameterisationIn, Parts
from modallab.api.updates.schemas import UPDATE_BODIES, coefficient_options, refuse
from modallab.api.wire import ModeCount, Number, Seed, Text, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.structure import Structure
from modallab.jobs.studying import StudyInputs
from modallab.rig.exact import as_modelled
from modallab.updating.error_location.method import LOCATORS
from modallab.updating.method import UPDATERS
from modallab.updating.options import SAMPLING
from modallab.updating.studies.plan import NOISE_LEVELS, Division, Level, StudyPlan, check_method
from modallab.updating.studies.settings import STUDY
from modallab.updating.studies.truth import true_coefficients


class LevelIn(ModeNoiseIn):
    """A level of noise with a name of its own."""

    name: Text
    """name of the level in the results"""

    def to_level(self) -> Level:
        """Return the level."""
        return Level(self.name, self.to_domain())


def _level(level: str | LevelIn) -> Level:
    if isinstance(level, LevelIn):
        return level.to_level()
    if level not in NOISE_LEVELS:
        raise InvalidInputError(
            f"there is no level {level!r}",
            field="levels",
            value=level,
            allowed=list(NOISE_LEVELS),
        )
    return Level(level, NOISE_LEVELS[level])


STUDY_METHODS = {**UPDATERS, **LOCATORS}
StudyOptionsBody = Annotated[
    Wire, OptionsByMethod({name: UPDATE_BODIES[method.options] for name, method in STUDY_METHODS.items()})
]


class StudyStart(Wire):
    """A method to be tried on modes of a known structure: levels of noise x divisions x seeds."""

    structure_id: Id = Field(description="the model that is corrected")
    truth_id: Id = Field(description="a changed copy of it, whose modes are drawn")
    method: Annotated[Text, OneOf(lambda: STUDY_METHODS)] = Field(
        default="one_shot", description="updating method that takes modes"
    )
    levels: Annotated[list[Text | LevelIn], Field(min_length=1, max_length=50)] = Field(
        default=list(NOISE_LEVELS), description="NL1 to NL4 of the 1992 thesis, or noise by its size"
    )
    divisions: Annotated[dict[Text, Macros], NamedByPattern(), Field(min_length=1, max_length=50)] = Field(
        default={"each": "each"}, description="macro elements by a name: as `macros` of an update"
    )
    seeds: Annotated[list[Seed], Field(min_length=1, max_length=STUDY.max_runs)] = Field(
        default=list(range(10)), description="seeds of the noise, one run each"
    )
    count: ModeCount = Field(default=10, description="modes that are measured")
    dofs: Dofs
    """DoFs at which shapes are measured, each once"""
    parts: Parts = None
    """parts of the member matrices that are corrected; null: those of the method"""
    lower: Number = 0.05
    """1, lower bound of every coefficient"""
    upper: Number = 10.0
    """1, upper bound of every coefficient"""
    options: StudyOptionsBody = Field(
        default_factory=dict, validate_default=True, description="options of the method"
    )

    def to_task(self, model: Structure, truth: Structure) -> tuple[StudyInputs, StudyPlan]:
        """Return the task's inputs and options, checked as far as can be before the work.

        Raises
        ------
        InvalidInputError
            If method, level, division, member, part, option or DoF is unknown or out of bounds, a name or a
            seed comes twice, there are too many runs, or the true structure is no changed copy of the model.
        """
        check_method(self.method)
        refuse(self.options.model_fields_set & set(SAMPLING), "a study")
        plan = StudyPlan(
            method=self.method,
            levels=tuple(_level(level) for level in self.levels),
            divisions=tuple(
                Division(name, self._parameters(macros).to_domain(model, self.method))
                for name, macros in self.divisions.items()
            ),
            seeds=tuple(self.seeds),
            count=self.count,
            dofs=distinct(self.dofs),
            options=coefficient_options(self.method, self.options),
        )
        true = true_coefficients(model, truth, plan.parts)
        _check_size(plan.n_runs, sum(map(len, true.values())))
        for structure in (model, truth):
            _check_dofs(structure, plan.dofs)
        return StudyInputs(self.structure_id, self.truth_id), plan

    def _parameters(self, macros: Macros) -> ParameterisationIn:
        return ParameterisationIn(macros=macros, parts=self.parts, lower=self.lower, upper=self.upper)


def _check_size(n_runs: int, n_coefficients: int) -> None:
    """Raise `InvalidInputError` where all runs together have more coefficients than are kept."""
    if n_runs * n_coefficients > REQUEST.study_coefficients:
        raise InvalidInputError(
            f"{n_runs} runs of {n_coefficients} coefficients are too much for one study",
            field="seeds",
            value=n_runs,
            allowed=bounds(maximum=REQUEST.study_coefficients // n_coefficients, unit="runs"),
        )


def _check_dofs(structure: Structure, dofs: tuple[Dof, ...]) -> None:
    """Raise `UnknownDofError` where a structure lacks one."""
    system = as_modelled(structure)
    for dof in dofs:
        system.index(dof)
