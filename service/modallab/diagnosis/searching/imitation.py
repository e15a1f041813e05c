"""Linear effects that may be the equivalent linearisation of a nonlinear force."""

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import Effect


def is_imitated(force: Effect, explanation: Effect, system: DynamicSystem) -> bool:
    """Return whether a linear explanation may be the linearisation of a nonlinear force at a DoF.

    At the same DoF, at the end of a suspected member, or on the whole structure; never in a channel.
    """
    if not explanation.structural or not isinstance(force.at, Dof):
        return explanation.structural
    if isinstance(explanation.at, Dof):
        return explanation.at == force.at
    if isinstance(explanation.at, Members) and system.members is not None:
        ends = zip(system.members.numbers, system.members.ends, strict=True)
        return any(force.at.node in pair for number, pair in ends if number in explanation.at.numbers)
    return True
