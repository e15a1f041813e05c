"""Closed sets of names in requests, read from the families of interchangeable parts."""

from typing import Annotated

from typing_extensions import TypeAliasType

from modallab.api.schema import OneOf
from modallab.api.wire import Text
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import REDUCTIONS
from modallab.rig.excitation import EXCITATIONS

_WindowName = OneOf(lambda: WINDOWS, "window function of the records")
WindowName = TypeAliasType("WindowName", Annotated[Text, _WindowName])
_EstimatorName = OneOf(lambda: ESTIMATORS, "estimator of FRFs")
EstimatorName = TypeAliasType("EstimatorName", Annotated[Text, _EstimatorName])
_ExcitationKind = OneOf(lambda: EXCITATIONS, "signal of the source")
ExcitationKind = TypeAliasType("ExcitationKind", Annotated[Text, _ExcitationKind])
CatalogueName = TypeAliasType(
    "CatalogueName",
    Annotated[Text, OneOf(lambda: STRUCTURES, "ready structure, of `GET /v1/catalog/structures`")],
)
ReductionKind = TypeAliasType(
    "ReductionKind",
    Annotated[Text, OneOf(lambda: REDUCTIONS, "reduction of a model to master degrees of freedom")],
)
