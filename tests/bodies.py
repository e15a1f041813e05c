"""Bodies of requests that several tests send."""

from typing import Any


def free_beam(n_elements: int = 8) -> dict[str, Any]:
    """Return the body of the beam that `tests.diagnosing` has, five modes below 400 Hz."""
    return {
        "kind": "beam",
        "length": 1.2,
        "n_elements": n_elements,
        "section": {"area": 5e-4, "second_moment": 4.1667e-9},
        "material": {"modulus": 2.09e11, "density": 7800.0},
        "damping": {"law": "structural", "stiffness_coefficient": 0.008, "mass_coefficient": 100.0},
    }
