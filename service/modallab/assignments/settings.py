"""Settings of assignments: when uploaded FRFs count as those of a sealed measurement."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class RecognitionSettings(Settings):
    """Comparison of uploaded FRFs with those of sealed measurements."""

    scatter: float = setting(
        5e-3,
        unit="1",
        doc="scatter of the ratio of two FRFs up to which they are the same data",
        derived="ten times the rounding of a text with three decimals",
    )
    share: float = setting(
        0.9,
        unit="1",
        doc="share of the lines whose ratio may scatter so much at most",
        derived="a file may round small values to nothing, at antiresonances",
    )
    most_lines: int = setting(
        200,
        unit="lines",
        doc="lines compared, evenly chosen",
        derived="by chance not even ten scatter so little",
    )
    fewest_lines: int = setting(
        8,
        unit="lines",
        doc="common lines without which nothing is compared",
        derived="too few for a fit of modes",
    )
    frequency: float = setting(
        0.01, unit="1", doc="distance of equal lines over the line spacing", derived="rounding of a text"
    )


RECOGNITION = RecognitionSettings()
