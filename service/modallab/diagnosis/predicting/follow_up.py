"""A further test of the same structure, with the changes against the first one."""

from dataclasses import dataclass, field, replace

from modallab.core.errors import InvalidInputError
from modallab.rig.change import Change
from modallab.rig.measurement import Measurement


@dataclass(frozen=True, eq=False)
class FollowUp:
    """A further test of the same structure, and the changes against the first one."""

    measurement: Measurement
    """The further test."""
    change: Change = field(default_factory=Change)
    """Changes of the log book against the first test."""

    def with_consistent_log_book(self, first: Measurement) -> Measurement:
        """Return the measurement with its log book as the change implies.

        Raises
        ------
        InvalidInputError
            If log book, change and measurement contradict each other.
        """
        frf = self.measurement.frf
        setup = self.change.agreed(self.measurement.setup, first.setup)
        for name, declared, measured in (
            ("drive", setup.drives, frf.inputs),
            ("responses", setup.responses, frf.outputs),
        ):
            if declared != measured:
                raise InvalidInputError(
                    f"the further test has other {name} than its log book with what was changed",
                    field=f"follow_ups.changed.{name}",
                    value=list(map(str, declared)),
                    allowed=list(map(str, measured)),
                )
        if setup.accelerometers.roving != first.setup.accelerometers.roving:
            raise InvalidInputError(
                "tests with a roving accelerometer and with fixed ones are not put together",
                field="follow_ups",
                value="roving" if setup.accelerometers.roving else "fixed",
                allowed="roving" if first.setup.accelerometers.roving else "fixed",
            )
        return replace(self.measurement, setup=setup)
