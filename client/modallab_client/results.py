"""Result types: what requests of the client return, generated from the service's OpenAPI document."""

from modallab_client._generated.models import (
    Diagnosis,
    EquivalentEffect,
    FittedEffect,
    FittedParameter,
    FollowUpTest,
    FrequencyInconsistency,
    Localisation,
    ModalModel,
    Mode,
    ModeShift,
    NextTest,
    ResponseMisfit,
    Rival,
    ShapeComplexity,
    Spread,
    Step,
    ToleratedParameter,
)
from modallab_client.methods.diagnoses import DiagnosisCurves

__all__ = [
    "Diagnosis",
    "DiagnosisCurves",
    "EquivalentEffect",
    "FittedEffect",
    "FittedParameter",
    "FollowUpTest",
    "FrequencyInconsistency",
    "Localisation",
    "ModalModel",
    "Mode",
    "ModeShift",
    "NextTest",
    "ResponseMisfit",
    "Rival",
    "ShapeComplexity",
    "Spread",
    "Step",
    "ToleratedParameter",
]
