"""Wire types of measurements."""

from typing import Any

from pydantic import ConfigDict

from modallab.api.deps import Id
from modallab.api.derived import body_of
from modallab.api.limits import REQUEST
from modallab.api.wire import Effects
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.structure import Structure
from modallab.jobs.measuring import MeasurementInputs, MeasurementOptions
from modallab.rig.effect import build
from modallab.rig.estimates import check_estimates
from modallab.rig.measure import Route
from modallab.rig.setup import RigSetup
from modallab.rig.time_records import check_records

MeasurementOptionsBody: Any = body_of(MeasurementOptions, enforced=True, effects=Effects)


class MeasurementStart(MeasurementOptionsBody):  # type: ignore[misc]
    """A virtual test. `effects` act in addition to those that the rig declares, and are in no log book."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    structure_id: Id
    """id of the structure under test"""
    rig_id: Id
    """id of the rig"""

    def to_task(self, structure: Structure, setup: RigSetup) -> tuple[MeasurementInputs, MeasurementOptions]:
        """Return the task's inputs and options, checked as far as can be before the work.

        Raises
        ------
        UnknownDofError
            If the rig drives or listens where the structure has no DoF.
        InvalidInputError
            If an effect is unknown, cannot sit where it is said to, or a value is out of bounds; if the
            test has too many lines and FRFs, or cannot keep so many time records or estimates.
        """
        _check_size(setup)
        for dof in (*setup.drives, *setup.responses):
            structure.index(dof)
        effects = [effect.to_domain() for effect in self.effects]
        for effect in [*effects, *(build(spec) for spec in (*structure.effects, *setup.effects))]:
            effect.check(structure, setup)
        specs = tuple(effect.spec for effect in effects)
        route = Route(self.route)
        check_records(self.records, setup, sampled=route is Route.SAMPLED)
        check_estimates(self.estimates, setup, sampled=route is Route.SAMPLED)
        options = MeasurementOptions(specs, route, self.seed, self.records, self.estimates)
        return MeasurementInputs(self.structure_id, self.rig_id), options


def _check_size(setup: RigSetup) -> None:
    """Raise `InvalidInputError` if a simulated test has too many lines and FRFs, or lines of no record."""
    values = len(setup.responses) * len(setup.drives) * setup.baseband.analyser.n_lines
    if values > REQUEST.test_values:
        raise InvalidInputError(
            "lines from 0 Hz on, times responses, are too many to simulate",
            field="n_lines",
            value=values,
            allowed=bounds(maximum=REQUEST.test_values),
        )
