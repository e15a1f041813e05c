"""Note on the leakage correction with several references."""

from collections.abc import Iterator

from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.responses import Responses


def white_forces_notes(responses: Responses, leakage: WindowLeakage | None) -> Iterator[str]:
    """Yield a note if records leak and there are several references.

    The effect of an exciter's armature on a single force follows from the drive-point FRF: see
    `WindowLeakage.correction`. Each of several forces depends on all drive points and all other forces.
    """
    n = len(responses.references)
    if leakage is not None and n > 1:
        yield (
            f"leakage with {n} references is corrected as if forces were white and independent; exciters with"
            " mass reduce all forces at resonances, and the shift of narrow modes by this is not part of the"
            " standard errors or flags"
        )
