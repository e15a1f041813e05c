"""Settings of the division of a structure into macro elements."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class PartitionSettings(Settings):
    """Macro elements of a structure that nobody has divided."""

    run_length: int = setting(
        4,
        unit="members",
        doc="members of an automatic macro element, at most",
        derived="1992 thesis: bars of seven are divided 4 + 3",
    )
    max_runs: int = setting(
        60,
        unit="macro elements",
        doc="runs beyond which connected parts of the structure take their place",
        derived="more than usual sets of modes can distinguish",
    )
    dissimilarity_weight: float = setting(
        0.1,
        doc="weight of a connection between members of different section, thickness or material",
        tuned="plates of 60 by 40 and 200 by 200 elements",
    )
    cut_slack: float = setting(
        0.05,
        doc="share of the smaller half by which a cut may move to where it cuts fewer connections",
        tuned="plates of 60 by 40 and 200 by 200 elements",
    )
    dense_vertices: int = setting(
        250,
        unit="vertices",
        doc="graph size up to which the Fiedler vector comes from a dense eigensolution",
        tuned="timings of dense and sparse solutions",
    )
    rounding_digits: int = setting(
        10,
        unit="digits",
        doc="decimal digits that order vertices, so that ties of symmetric graphs stay ties",
        derived="below the rounding of an eigenvector",
    )


PARTITION = PartitionSettings()
