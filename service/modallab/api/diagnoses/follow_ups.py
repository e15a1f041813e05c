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
    """DoF that carries the mass; `sensors`: every accelerometer"""


class ChangedIn(Wire):
    """Changes against the first test; a field that is left out is unchanged."""

    level_factor: Number | None = None
    """1, rms of the source over that of the first test"""
    averages_factor: Number | None = None
    """1, number of averages over that of the first test"""
    n_lines: Count | None = None
    """frequency lines, 0 Hz included"""
    frequency_max: Number | None = None
    """Hz, highest line of the analyser"""
    window: Text | None = None
    """window of the analyser"""
    excitation: Text | None = None
    """kind of excitation"""
    exciter: Literal["shaker", "hammer"] | None = None
    """kind of exciter"""
    drive: DofText | None = None
    """DoF of the excitation"""
    responses: list[DofText] = Field(default=[], max_length=2000)
    """DoFs of the responses; empty: those of the first test"""
    added_mass: AddedMassIn | None = None
    """known mass that was added for the test"""

    def to_domain(self) -> Change:
        """Return the change.

        Raises
        ------
        InvalidInputError
            If a value has no meaning.
        """
        return Change.read(self.model_dump(exclude_defaults=True))


class FollowUpIn(Wire):
    """Further test. `changed` states the changes against the first test that its log book does not show."""

    measurement_id: Id
    """measurement of the further test"""
    changed: ChangedIn = ChangedIn()
    """changes against the first test that its log book does not show"""

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
