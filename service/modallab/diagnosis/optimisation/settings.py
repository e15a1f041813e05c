"""Settings of least squares: differences, steps, priors and bounds of nuisance parameters."""

from dataclasses import dataclass
from typing import Any

from modallab.core.settings import Settings, setting

TESTS = "simulated tests of the suite"


@dataclass(frozen=True)
class DifferenceSettings(Settings):
    """Finite differences of residuals."""

    step: float = setting(
        3e-6,
        doc="step of a parameter on its fitted (logarithmic or scaled) axis",
        derived="far above rounding; at 1e-4 sharp resonances show their curvature",
    )
    min_value: float = setting(
        0.1,
        doc="share of a parameter's scale below which its step on the physical axis shrinks no further",
        derived="keeps the step of a parameter near zero finite",
    )
    max_step: float = setting(
        0.1,
        doc="largest step, on the fitted axis, of a parameter that is a place or shape and not an amount",
        tuned=TESTS,
    )
    linear_change: float = setting(
        0.1,
        unit="standard deviations",
        doc="change of the residuals over the small step above which it is taken for linear",
        tuned=TESTS,
    )
    linearity: float = setting(
        2.0,
        doc="change over the long step, in terms of the predicted one, up to which residuals are linear",
        tuned=TESTS,
    )
    max_refinements: int = setting(
        6,
        unit="evaluations",
        doc="trials for the step over which the residuals change by about one standard deviation",
        tuned=TESTS,
    )
    lower_bound: float = setting(
        1e-12,
        doc="least value of a parameter on a logarithmic axis, over its scale",
        derived="a positive number so small that its effect is rounding",
    )


@dataclass(frozen=True)
class LeastSquaresSettings(Settings):
    """Bounded Gauss-Newton minimisation."""

    first_step: float = setting(
        1.0,
        doc="first trust region, of any coordinate",
        derived="a factor e of a parameter on a logarithmic axis, one scale of any other",
    )
    poor_gain: float = setting(
        0.25, doc="share of the predicted gain below which the derivatives are renewed", tuned=TESTS
    )
    slow_gain: float = setting(
        0.1,
        doc="share of the last predicted gain above which corrected derivatives are renewed",
        tuned=TESTS,
    )
    shrinkage: float = setting(
        4.0, doc="divisor of the trust region after a step that does not reduce the cost", tuned=TESTS
    )
    growth: float = setting(
        2.0, doc="trust region after a successful step, over the step", derived="doubling, as is usual"
    )
    least_independence: float = setting(
        1e-4,
        doc="share of a column that others leave, below which products of columns are not precise enough",
        derived="its square has eight digits left in double precision",
    )
    pivots: int = setting(
        12,
        unit="solutions",
        doc="solutions of least squares between bounds, before its parameters change sides one at a time",
        derived="three or four are enough mostly",
    )
    projected_steps: int = setting(
        5,
        unit="steps",
        doc="projected Newton steps on a bounded quadratic form, the clipped Newton step included",
        tuned=TESTS,
    )


@dataclass(frozen=True)
class NuisanceSettings(Settings):
    """Nuisance parameters: what may differ a little from model and log book."""

    unknown_loss_factor: float = setting(
        1.5,
        unit="1",
        doc="standard deviation of the logarithm of an unknown loss factor",
        derived="a factor of 90 either way within the largest deviation",
    )
    loss_margin: float = setting(
        1.25,
        doc="highest frequency of a mode that always has a loss factor of its own, over the top of the band",
        derived="an effect that lowers it by a fifth brings it into the band",
    )
    loss_reach: float = setting(
        6.0,
        doc="highest frequency of a mode that has one if the test shows it, over the top of the band",
        derived="its share of a response at the top of the band is a thirty-sixth of a mode's at the top",
    )
    least_visibility: float = setting(
        1.0,
        unit="independent squared errors",
        doc="change of the residuals by one standard deviation of a parameter that a test shows",
        derived="a smaller one is not told from random error",
    )
    max_deviation: float = setting(
        3.0,
        unit="standard deviations",
        doc="largest deviation of a nuisance parameter; of many alike the largest of all is as likely",
        derived="3 sigma: one of 370 by chance; a prior alone cannot hold against 20,000 data",
    )
    difference_step: float = setting(
        2e-6,
        doc="step of the finite difference by a nuisance parameter, as a share of its declared value",
        derived="eigenvalues are precise to 1e-9; a resonance of loss factor 2.5e-4 moves by a hundredth of "
        "its bandwidth",
    )
    least_difference_step: float = setting(
        1e-5,
        unit="standard deviations",
        doc="least step of the finite difference, and the step of a delay",
        derived="the prediction with a delay has a closed form, free of the rounding of eigenvalues",
    )
    parameter_range: float = setting(
        1.0,
        doc="change of an accepted effect's parameter, on its fitted axis, beside a candidate",
        derived="a factor e of a parameter on a logarithmic axis, one scale of any other",
    )


@dataclass(frozen=True)
class RandomFieldSettings(Settings):
    """Smooth deviations of the members' modulus and density."""

    correlation_length: float = setting(
        0.1,
        doc="correlation length over the largest extent of the structure",
        derived="half a wavelength of the ninth bending mode of a free beam (beta L = 29.8)",
    )
    least_corner: float = setting(
        30.0,
        unit="degrees",
        doc="angle between neighbouring members from which on they are parts of different bars",
        derived="a circle of 12 members or more is one bar; corners of frames are 45 to 90 degrees",
    )
    small_deviation: float = setting(
        5e-4,
        doc="standard deviation of a member's factor by the shapes that only a test that shows them has",
        derived="a twentieth of the bandwidth of 0.5 % damping",
    )
    omitted_deviation: float = setting(
        1e-6,
        doc="standard deviation of what the retained shapes omit of a member's factor",
        derived="moves a resonance of 0.1 % damping by a thousandth of its bandwidth",
    )
    max_shapes: int = setting(
        40, unit="shapes", doc="shapes of a field at most: each costs a prediction a step", tuned=TESTS
    )


@dataclass(frozen=True)
class ToleranceSettings(Settings):
    """Largest tolerances that a request may state."""

    max_relative: float = setting(
        0.3,
        doc="largest relative tolerance, one standard deviation",
        derived="three standard deviations leave a tenth of the value",
    )
    max_delay: float = setting(
        3e-3, unit="s", doc="largest tolerance of a delay, one standard deviation", tuned=TESTS
    )


PRESET_NAMES = ("careful", "ordinary", "student")


def _preset(careful: float, ordinary: float, student: float, doc: str, **texts: str) -> Any:
    """Declare a tolerance of each preset, one standard deviation."""
    return setting((careful, ordinary, student), doc=doc, **{"unit": "1", **texts})


@dataclass(frozen=True)
class PresetSettings(Settings):
    """Tolerances of the presets `careful`, `ordinary` and `student`, one standard deviation each."""

    modulus: tuple[float, float, float] = _preset(
        0.003, 0.01, 0.03, "Young's modulus", derived="certified; of a handbook; of the material's name"
    )
    density: tuple[float, float, float] = _preset(
        0.002, 0.005, 0.02, "density", derived="weighed; of a handbook; dimensions by a ruler"
    )
    sensitivity: tuple[float, float, float] = _preset(
        0.003, 0.01, 0.03, "sensitivity of a transducer", derived="calibrated on the day; a year ago; once"
    )
    accelerometer_mass: tuple[float, float, float] = _preset(
        0.01, 0.03, 0.1, "mass of the accelerometers", derived="weighed; data sheet; with stud or cable"
    )
    delay: tuple[float, float, float] = _preset(
        1e-6,
        2e-6,
        1e-5,
        "delay between channels",
        unit="s",
        derived="a hundredth of a sample and more at 10 to 50 kHz",
    )
    modal_loss_factor: tuple[float, float, float] = _preset(
        0.1,
        0.2,
        0.3,
        "logarithm of the loss factor of a mode",
        derived="damping is known to ten or more per cent, and never below zero",
    )
    modulus_variation: tuple[float, float, float] = _preset(
        0.002, 0.005, 0.02, "modulus along the structure", derived="extruded; rolled; cast or drilled stock"
    )
    density_variation: tuple[float, float, float] = _preset(
        0.002, 0.005, 0.02, "mass along the structure", derived="thickness tolerances of such stock"
    )


DIFFERENCE = DifferenceSettings()
LEAST_SQUARES = LeastSquaresSettings()
NUISANCE = NuisanceSettings()
RANDOM_FIELD = RandomFieldSettings()
TOLERANCE = ToleranceSettings()
PRESET = PresetSettings()
