"""Destination of a task's result."""

import hashlib
from dataclasses import dataclass


@dataclass(frozen=True)
class Destination:
    """Owner and id of a result, fixed when the job was submitted."""

    owner: str
    id: str

    def derived_id(self, name: str) -> str:
        """Return the id of a further result of the task, the same in every run."""
        return hashlib.sha256(f"{self.id}/{name}".encode()).hexdigest()[:24]
