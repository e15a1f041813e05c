"""Settings of the fit of all modes to all FRFs, and of its covariance."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting

MEMORY = "memory: 32 MB an array"


@dataclass(frozen=True)
class ModalFitSettings(Settings):
    """Gauss-Newton steps on the eigenvalues of all modes."""

    iterations: int = setting(
        40, doc="Largest number of steps.", derived="four to eight are taken from a pole finder's start"
    )
    usual_iterations: int = setting(
        6, doc="Steps after which half of the progress is reported.", tuned="starts from a pole finder"
    )
    most_rounding: float = setting(
        0.1,
        doc="Eigenvalue of a unit normal matrix above which its parameters are determined.",
        derived="of independent parameters it is near 1",
    )
    convergence: float = setting(
        0.001,
        unit="standard errors",
        doc="Largest step of a pole in the range at which the fit ends.",
        derived="far below the random error",
    )
    residual_gain: float = setting(
        1e-4,
        unit="misfits",
        doc="Decrease of the misfit for which modes outside the range are moved further.",
        derived="a smaller one changes the residuals by less than a ten-thousandth",
    )
    last_step: float = setting(
        0.1,
        unit="standard errors",
        doc="Largest step of a pole in the range that may be the last.",
        derived="the error left by a Gauss-Newton step is quadratic in it",
    )
    smallest_gain: float = setting(
        1.0,
        unit="random errors per unknown",
        doc="Decrease of the misfit below which such a step is the last.",
        derived="a smaller decrease is insignificant",
    )
    similar_share: float = setting(
        0.5, doc="Share of the time for steps with similar weights.", tuned="durations with 222 FRFs"
    )
    insensitivity: float = setting(
        1e-9,
        unit="misfits",
        doc="Change of the misfit that is rounding.",
        derived="rounding of the sums over lines, and of directions that the lines do not determine",
    )
    largest_step: float = setting(
        0.5,
        unit="imaginary parts of the eigenvalue",
        doc="Largest step.",
        derived="beyond it the linearisation does not hold",
    )
    lowest_frequency: float = setting(
        0.3,
        unit="lower limits",
        doc="Least frequency of a pole below the range.",
        derived="a pole further below is a mass line and would drift",
    )
    highest_frequency: float = setting(
        1.4,
        unit="upper limits",
        doc="Largest frequency of a pole above the range.",
        derived="a pole further above is a constant and would drift",
    )
    largest_loss_factor: float = setting(
        1.9,
        doc="Largest loss factor of a viscous pole.",
        derived="from 2 on the pole is real and has no modal constant",
    )
    first_damping: float = setting(
        1e-4,
        unit="diagonal entries",
        doc="Levenberg-Marquardt damping at the start.",
        derived="Marquardt's scaled form: a nearly full Gauss-Newton step",
    )
    damping_increase: float = setting(10.0, doc="Factor after a failure.", derived="Marquardt (1963)")
    damping_decrease: float = setting(0.1, doc="Factor after a success.", derived="Marquardt (1963)")


@dataclass(frozen=True)
class ProjectionSettings(Settings):
    """Sums over lines, and residuals of a range."""

    products_in_memory: int = setting(
        2**22, unit="numbers", doc="Size of a block of products.", derived=MEMORY
    )
    least_group: int = setting(
        4,
        unit="lines",
        doc="Mean size of groups of lines from which sums are taken by groups.",
        derived="a group takes as long as a few lines",
    )
    similar_lines: int = setting(
        16,
        unit="lines",
        doc="Largest group of lines with one weight in the first steps of a fit.",
        derived="cost of the sums; the last steps have the weights of the lines, so that only their number"
        " depends on it",
    )
    wide_range: float = setting(
        0.5,
        unit="upper limits",
        doc="Lower limit of a range below which out-of-band modes are not constant in it.",
        tuned="doubled, no test of this room fails; halved, tests fail whose range is counted as wide",
    )
    many_lines: int = setting(
        64,
        unit="lines",
        doc="Lines above which a range determines out-of-band poles.",
        tuned="halved and doubled, tests of this room fail that count on the side on which their range lies",
    )
    fixed_poles: tuple[float, ...] = setting(
        (1.5,),
        unit="upper limits",
        doc="Frequencies of undamped poles above a wide range.",
        derived="with a constant they represent all higher modes to 3 %, except for the next one",
    )


@dataclass(frozen=True)
class ModalCovarianceSettings(Settings):
    """Standard errors of the common fit."""

    common_noise_deviations: float = setting(
        3.0,
        unit="standard deviations",
        doc="Correlation of FRFs that is significant.",
        derived="3 sigma: one of 370 by chance",
    )
    simultaneous_part: float = setting(
        0.5,
        doc="Correlation of FRFs, over that by noise of one force, from which all were recorded together.",
        derived="two runs of as many FRFs each leave less than half of the pairs with one force",
    )
    frfs_in_memory: int = setting(32, unit="FRFs", doc="FRFs that are treated together.", derived="memory")


MODAL_FIT = ModalFitSettings()
PROJECTION = ProjectionSettings()
MODAL_COVARIANCE = ModalCovarianceSettings()
