"""Settings of direct updating methods."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class DirectSettings(Settings):
    """Matrices, rigid-body modes and accuracy of direct updating."""

    max_dofs: int = setting(
        1500,
        unit="DoFs",
        doc="size of full matrices",
        derived="four matrices of 1500 by 1500 doubles are 72 MB",
    )
    rigid_body_ratio: float = setting(
        1e-4,
        doc="omega^2 over the lowest measured one below which a mode of the model is a rigid-body mode",
        derived="a hundredth of its frequency: rounding, no elastic mode",
    )
    max_condition: float = setting(
        1e10,
        doc="condition number of the modal mass beyond which measured shapes are dependent",
        derived="ten digits lost leave six of a double",
    )
    reproduction_error: float = setting(
        1e-6,
        doc="error of frequency or modal assurance criterion up to which measured modes are reproduced",
        derived="rounding of an eigensolution, three decades aside",
    )


DIRECT_UPDATING = DirectSettings()
