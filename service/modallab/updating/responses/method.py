"""Family of updating methods on frequency responses."""

from modallab.core.registry import Family
from modallab.updating.method import UpdatingMethod
from modallab.updating.responses.target import TargetResponses

RESPONSE_UPDATERS: Family[UpdatingMethod[TargetResponses]] = Family(
    "updating method", home="modallab.updating.responses.methods"
)
