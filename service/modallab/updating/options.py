"""Options of the updating methods."""

from dataclasses import dataclass
from enum import StrEnum

from modallab.core.options import Options, option
from modallab.updating.modal_residuals import Balance
from modallab.updating.sparse_bayes import Prior


class Underdetermined(StrEnum):
    """Treatment of an update with fewer measured numbers than coefficients."""

    REFUSED = "refused"
    REGULARISED = "regularised"


@dataclass(frozen=True)
class RankOptions(Options):
    """Options of a method that solves linear equations of limited rank."""

    rank_jump: float = option(
        1e3, unit="1", lower=2.0, upper=1e15, doc="ratio of consecutive singular values that ends the rank"
    )


@dataclass(frozen=True)
class PairingOptions(Options):
    """Options of a method that pairs measured modes with those of the model."""

    min_mac: float = option(
        0.3,
        unit="1",
        lower=0.0,
        upper=1.0,
        doc="modal assurance criterion below which a measured and a model mode do not pair",
    )


@dataclass(frozen=True)
class UpdateOptions(RankOptions):
    """Options of every method that corrects coefficients by iteration."""

    max_iterations: int = option(30, unit="1", lower=1, upper=1000, doc="largest number of steps of a stage")
    tolerance: float = option(
        1e-4,
        unit="1",
        lower=1e-12,
        upper=1.0,
        doc="largest change of a coefficient that ends the last stage",
    )
    identified_within: float = option(
        0.3,
        unit="1",
        lower=1e-6,
        upper=10.0,
        doc="relative standard error, by the data alone, above which a coefficient is not identified",
    )


@dataclass(frozen=True)
class TwoStageOptions(UpdateOptions, PairingOptions):
    """Options of a method that locates errors in macro elements, then corrects the elements inside them."""

    location_tolerance: float = option(
        0.01,
        unit="1",
        lower=1e-12,
        upper=1.0,
        doc="largest change of a macro element's coefficient that ends the location stage",
    )
    suspect_threshold: float = option(
        0.08, unit="1", lower=0.0, upper=10.0, doc="distance from 1 at which a macro element is suspected"
    )
    max_step: float = option(
        0.3,
        unit="1",
        lower=1e-3,
        upper=10.0,
        doc="largest change of a coefficient in one step of the updating stage",
    )
    n_shapes: int = option(
        1000,
        unit="1",
        lower=0,
        upper=1000,
        doc="number of lowest measured modes whose shapes count; of the others only the eigenvalue",
    )
    balance: Balance = option(
        Balance.EIGENVALUES,
        doc="rows divided by their size: those of eigenvalues alone, or both these and those of shapes",
    )

    @property
    def loss_factor_threshold(self) -> float:
        """Loss factor from which the damping of a macro element is suspected."""
        return self.suspect_threshold


@dataclass(frozen=True)
class ComplexTwoStageOptions(TwoStageOptions):
    """Options of a two-stage method that also corrects damping."""

    damping_threshold: float = option(
        0.008,
        unit="1",
        lower=0.0,
        upper=2.0,
        doc="loss factor from which the damping of a macro element is suspected",
    )

    @property
    def loss_factor_threshold(self) -> float:
        """Loss factor from which the damping of a macro element is suspected."""
        return self.damping_threshold


@dataclass(frozen=True)
class ResponseUpdateOptions(UpdateOptions):
    """Options of a method that corrects all coefficients in one stage, with a prior."""

    prior: Prior = option(
        Prior.SPARSE,
        doc="prior of the coefficients: sparse, few elements are wrong; common, many are a little wrong; "
        "range, only the bounds",
    )
    underdetermined: Underdetermined = option(
        Underdetermined.REFUSED, doc="treatment of fewer measured numbers than coefficients"
    )


@dataclass(frozen=True)
class OneStageOptions(ResponseUpdateOptions, PairingOptions):
    """Options of a method that corrects all coefficients in one stage from modes."""

    samples: int = option(
        0, unit="1", lower=0, upper=100_000, doc="number of draws from the posterior; 0: none"
    )
    seed: int = option(0, unit="1", lower=0, upper=2**63 - 1, doc="seed of these draws")


SAMPLING = ("samples", "seed")  # of `OneStageOptions`: a study of many runs draws no samples


@dataclass(frozen=True)
class LocationOptions(RankOptions, PairingOptions):
    """Options of a method that locates errors by one linear step."""

    suspect_threshold: float = option(
        0.08, unit="1", lower=0.0, upper=10.0, doc="change of a coefficient from which it is suspected"
    )
