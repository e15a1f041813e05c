"""Jobs: end of a background task."""

from typing import TYPE_CHECKING

from modallab_client import _tables

FINISHED = ("succeeded", "failed", "cancelled")


class JobStatusMethods:
    """Test for the end of a job."""

    if TYPE_CHECKING:
        id: str
        fraction: float
        message: str

        @property
        def state(self) -> str:
            """State of the job."""
            ...

    @property
    def finished(self) -> bool:
        """Whether the status is final."""
        return self.state in FINISHED

    def _repr_html_(self) -> str:
        rows = [("state", self.state), ("done", f"{self.fraction:.0%}"), ("message", self.message)]
        return _tables.html((), rows, caption=f"Job {self.id}")
