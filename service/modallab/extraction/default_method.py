"""Method of an extraction where none is named."""

from dataclasses import dataclass

from modallab.extraction.multi_mode.chart_settings import MATRIX_FRACTION
from modallab.extraction.options import DistantLinesOptions, ExtractionOptions

SINGLE_REFERENCE = "dobson"
FEW_REFERENCES = "poly_reference_lscf"
MANY_REFERENCES = "lscf"


@dataclass(frozen=True)
class MethodChoice:
    """Extraction method with the reason for it."""

    method: str
    """Name of the method."""
    reason: str
    """Method and reason, as in the `choices` of a modal model."""


def default_method(n_references: int, options: ExtractionOptions | None) -> MethodChoice:
    """Return the default method for a number of references.

    With several references, modes whose peaks overlap can be separated: their FRFs are fitted together with
    one shape and its participation factors. FRFs of a single reference are fitted separately, which shows
    where their frequencies differ.

    Parameters
    ----------
    n_references
        Number of references: drive points, or accelerometers of a roving hammer.
    options
        Options requested; those of single-mode fits choose a single-mode method.
    """
    if isinstance(options, DistantLinesOptions) and (options.lines is not None or options.leave_out):
        method, why = SINGLE_REFERENCE, "the default with options of single-mode fits"
    elif n_references == 1:
        method = SINGLE_REFERENCE
        why = (
            "the default with one reference: it fits FRF by FRF, and shows where their frequencies differ; "
            "modes closer than their bandwidths need lscf"
        )
    elif n_references <= MATRIX_FRACTION.largest_inputs:
        method = FEW_REFERENCES
        why = (
            f"the default with {n_references} references: their FRFs together tell modes apart that form"
            " one peak, and show those that are weak at one of them"
        )
    else:
        method = MANY_REFERENCES
        why = (
            f"the default with {n_references} references, more than the {MATRIX_FRACTION.largest_inputs} that"
            f" {FEW_REFERENCES} fits together"
        )
    return MethodChoice(method, f"{method}: {why}")
