"""Wire types of further tests of the same structure."""

from typing import Annotated, Literal

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.wire import Count, DofText, Number, Text, Wire
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.fe.structure import Structure
from modallab.jobs.diagnosing import FurtherTest
from modallab.rig.change import Change
from modallab.store.base import Store


class AddedMassIn(Wire):
    """A known mass, stuck on for a test: at a DoF, or on the accelerometers."""

    mass: Annotated[Number, Field(description="kg")]
    at: Literal["sensors"] | DofText = "sensors"


class ChangedIn(Wire):
    """What was changed against the first test; what is left out is the same."""

    level_factor: Annotated[Number, Field(description="on the rms of the source")] | None = None
    averages_factor: Number | None = None
    n_lines: Count | None = None
    frequency_max: Annotated[Number, Field(description="Hz")] | None = None
    window: Text | None = None
    excitation: Annotated[Text, Field(description="kind of excitation")] | None = None
    exciter: Literal["shaker", "hammer"] | None = None
    drive: DofText | None = None
    responses: list[DofText] = Field(default=[], max_length=2000)
    added_mass: AddedMassIn | None = None

    def to_domain(self) -> Change:
        """Return the change.

        Raises
        ------
        InvalidInputError
            If a value has no meaning.
        """
        return Change.read(self.model_dump(exclude_defaults=True))


class FollowUpIn(Wire):
    """A further test. Its log book counts; where that does not show what was changed, `changed` does."""

    measurement_id: Id
    changed: ChangedIn = ChangedIn()

    def to_domain(self) -> FurtherTest:
        """Return the measurement and the change as a task takes them."""
        return FurtherTest(self.measurement_id, self.changed.to_domain().plain)


def check_follow_ups(
    store: Store, structure: Structure, measurement_id: str, follow_ups: list[FollowUpIn], *, act: bool
) -> None:
    """Raise unless the further tests fit the first one, and may be asked for.

    Raises
    ------
    NotFoundError
        If a measurement is not there.
    UnknownDofError
        If the structure lacks a DoF of a further test.
    InvalidInputError
        If a log book contradicts what is said to have been changed, or the first test was not made here.
    """
    if not follow_ups and not act:
        return
    first = store.measurements.get(measurement_id)
    if act and first.route is None:
        raise InvalidInputError(
            "the rig that this was measured on is not ours: do the proposed test there, and send it as a "
            "follow-up",
            field="act",
            value="true",
            allowed="false, or a measurement that was made here",
        )
    for item in follow_ups:
        follow_up = FollowUp(store.measurements.get(item.measurement_id), item.changed.to_domain())
        setup = follow_up.with_consistent_log_book(first).setup
        for dof in (*setup.drives, *setup.responses):
            structure.index(dof)
