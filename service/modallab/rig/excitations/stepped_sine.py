"""Stepped sine excitation."""

from modallab.rig.excitation import EXCITATIONS, Excitation, swept_phases

# The sines of all lines, each in a record of its own, are the lines of one record in a linear test. They
# are laid into it with phases that give it no high peak, so that a converter's range is not asked for
# what no sine alone would ask.
EXCITATIONS.register("stepped_sine")(
    Excitation(
        summary="one line after the other, each in steady state: neither leakage nor window, little noise",
        phases=swept_phases,
        line_by_line=True,
    )
)
