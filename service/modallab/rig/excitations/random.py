"""Pure random excitation."""

from modallab.rig.excitation import EXCITATIONS, Excitation

EXCITATIONS.register("random")(
    Excitation(summary="stationary Gaussian noise: never periodic in a record, so it leaks", continuous=1.0)
)
