"""Jobs: end of a background task."""

from typing import TYPE_CHECKING

FINISHED = ("succeeded", "failed", "cancelled")


class JobStatusMethods:
    """Test for the end of a job."""

    if TYPE_CHECKING:

        @property
        def state(self) -> str:
            """State of the job."""
            ...

    @property
    def finished(self) -> bool:
        """Whether the status is final."""
        return self.state in FINISHED
