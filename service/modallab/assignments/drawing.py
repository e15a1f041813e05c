"""Numbers drawn from a secret: the same for the same names, and not to be guessed without it."""

import hashlib
import hmac
from dataclasses import dataclass


@dataclass(frozen=True)
class Lot:
    """A source of numbers, named by what they are for."""

    secret: str
    """Secret of the assignment, which no reply tells."""
    name: str
    """What the numbers are for; another name gives other numbers."""

    def integer(self, index: int = 0) -> int:
        """Return the integer of this index, 0 to 2^63 - 1: all bits depend on the secret."""
        message = f"{self.name}/{index}".encode()
        digest = hmac.new(self.secret.encode(), message, hashlib.sha256).digest()
        return int.from_bytes(digest[:8], "big") >> 1

    def fraction(self, index: int = 0) -> float:
        """Return the number of this index, 0 to less than 1, of uniform distribution."""
        return (self.integer(index) >> 10) / 2**53  # as many bits as a number has
