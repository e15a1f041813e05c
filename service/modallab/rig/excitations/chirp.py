"""Periodic chirp."""

from modallab.rig.excitation import EXCITATIONS, Excitation, swept_phases

EXCITATIONS.register("chirp")(
    Excitation(
        summary="a fast sweep from 0 Hz to the top of the band, once a record: no leakage, small peaks",
        phases=swept_phases,
    )
)
