"""Limits of what solids, structures and tests do; beyond them a number is a slip of a unit."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class PlausibilitySettings(Settings):
    """Limits that no structure under test exceeds."""

    modulus: tuple[float, float] = setting(
        (1e5, 2e12),
        unit="N/m^2",
        doc="least and largest modulus of elasticity",
        derived="gels have 1e5 and carry no structure; diamond has 1.2e12; 209 is steel in GPa",
    )
    density: tuple[float, float] = setting(
        (10.0, 25e3),
        unit="kg/m^3",
        doc="least and largest density",
        derived="the lightest foams that are built with have 15, osmium 22,600; 7.8 is steel in t/m^3",
    )
    wave_speed: tuple[float, float] = setting(
        (10.0, 20e3),
        unit="m/s",
        doc="least and largest speed of longitudinal waves in a bar, sqrt(E/rho)",
        derived="30 in soft rubber, 1,200 in lead, 5,200 in steel and aluminium, 18,000 in diamond",
    )
    extent: float = setting(
        500.0,
        unit="m",
        doc="largest extent of a structure",
        derived="longer than the spans and towers that are tested with exciters; 1,200 is a length in mm",
    )
    compactness: tuple[float, float] = setting(
        (1e-7, 1e5),
        unit="1",
        doc="least and largest second moment of area over the square of the area of a section",
        derived="1/(12 n) of a strip n times as wide as thick, n/(8 pi) of a tube n times as wide as its "
        "wall, h^2/4 per area of two flanges h apart; mm^2 or mm^4 beside m are off by 1e12",
    )
    frequency: tuple[float, float] = setting(
        (0.01, 1e6),
        unit="Hz",
        doc="least and largest first elastic natural frequency",
        derived="the longest suspension bridge has 0.04 Hz; a steel bar of 3 mm has 1 MHz along its axis",
    )
    solved_dofs: int = setting(
        400,
        unit="DoFs",
        doc="size of a structure up to which its first frequency is computed for a warning",
        derived="some milliseconds: a reply does not wait for it",
    )
    top_frequency: float = setting(
        1.0,
        unit="Hz",
        doc="last line below which a test is too slow to be meant",
        derived="bridges are tested to some Hz; 0.8 is a range in kHz",
    )


PLAUSIBLE = PlausibilitySettings()
