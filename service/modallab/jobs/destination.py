"""Where a task's result goes."""

import hashlib
from dataclasses import dataclass


@dataclass(frozen=True)
class Destination:
    """Whose a result is, and its id, fixed when the job was submitted."""

    owner: str
    id: str

    def derived_id(self, name: str) -> str:
        """Return the id of something else the task makes, the same however often it runs."""
        return hashlib.sha256(f"{self.id}/{name}".encode()).hexdigest()[:24]
