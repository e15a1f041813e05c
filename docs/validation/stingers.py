"""The stingers of the thesis: appendix D."""

from docs.validation.comparison import Comparison, quantity
from modallab.rig.stinger import StingerRod, axial_frequency
from tests.published.tables import table

PRINTED = table("stinger_1992")
CONSTANT = "the thesis takes 3 pi/2 for the root 4.730 of the frequency equation: 0.8 % less"
ROUNDED = "from its dimensions; the print rounds up"


def comparisons() -> list[Comparison]:
    """Return the table of appendix D."""
    material, axial, quantities = PRINTED["material"], PRINTED["axial"], []
    for which, length in PRINTED["lengths"].items():
        rod = StingerRod(material["diameter"], length, material["modulus"], material["density"])
        stiffness = axial[f"{which}_stiffness"]
        name = f"{1e3 * length:.0f} mm"
        rounded = ROUNDED if which == "short" else ""
        quantities += [
            quantity(f"{name}: bending, Hz", PRINTED["bending"][which], rod.bending_frequency, 0, CONSTANT),
            quantity(
                f"{name}: axial stiffness, MN/m",
                stiffness / 1e6,
                rod.axial_stiffness / 1e6,
                2 if which == "short" else 3,
                rounded,
            ),
            quantity(
                f"{name}: axial, Hz",
                axial["short_as_printed" if which == "short" else which],
                axial_frequency(rod.axial_stiffness, material["armature_mass"]),
                0,
                "two digits changed places in print: the printed stiffness gives 5971" if rounded else "",
            ),
        ]
    return [Comparison("Table D.1", "resonances of the stingers", tuple(quantities))]
