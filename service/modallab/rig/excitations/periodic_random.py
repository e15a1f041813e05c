"""Periodic random excitation."""

from modallab.rig.excitation import EXCITATIONS, Excitation

EXCITATIONS.register("periodic_random")(
    Excitation(
        summary="a new random record for every average, repeated until the response is steady: no leakage",
        continuous=0.0,
    )
)
