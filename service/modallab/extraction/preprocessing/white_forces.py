"""A word of warning where leakage of several forces is undone as if they were white."""

from collections.abc import Iterator

from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.responses import Responses


def white_forces_notes(responses: Responses, leakage: WindowLeakage | None) -> Iterator[str]:
    """Yield a note where records leak and there are several references.

    What an exciter's mass takes of one force is known from the FRF of its drive point: see
    `WindowLeakage.undone`. Of several forces each follows all drive points and all other forces.
    """
    n = len(responses.references)
    if leakage is not None and n > 1:
        yield (
            f"leakage of {n} references is undone as if forces were white and independent; exciters with mass"
            " make them drop at resonances, together, and move narrow modes by what no error or flag holds"
        )
