"""Linear fit: mode and residual from Levy's equation, linear in its unknowns."""

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.options import DistantLinesOptions
from modallab.extraction.single_mode.lines import fit_mode_and_constant, physical_fits, scale, single_window
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)


@in_blocks
def linear_fit(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Mode and constant residual from one equation that is linear in its three unknowns.

    `alpha = A/(lambda_r - omega^2) + R` times its denominator is `alpha omega^2 = lambda_r alpha + c + R
    omega^2`, `c = -(A + R lambda_r)`. This multiplies the errors of the lines by the denominator, for which
    the weights compensate; they are renewed with every solution.

    Parameters
    ----------
    freq, frf, weight
        As `ExtractionMethod`.

    References
    ----------
    Levy, E. C. (1959), IRE Transactions on Automatic Control 4, 37-43, the linear equation; Sanathanan, C. K.
    and Koerner, J. (1963), IEEE Transactions on Automatic Control 8, 56-58, the renewed weights.
    """
    lines = scale(freq, frf, weight)
    return physical_fits(lines, *fit_mode_and_constant(lines))


def linear_fit_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """Return both sides of the equation: `alpha omega^2`, and the fitted sum of three terms."""
    lines, x, points = single_window(freq, frf, weight)
    eigenvalue, constant, residual = fit_mode_and_constant(lines)
    pole = lines.centre + lines.half * eigenvalue
    left_over = lines.size * residual
    level = -(lines.half * lines.size * constant + left_over * pole)
    return {
        "x": x,
        "points": points,
        "left": points * x,
        "right": pole * points + level + left_over * x,
    }


EXTRACTION_METHODS.register("linear_fit")(
    SingleModeMethod(fit=linear_fit, plot=linear_fit_plot, options=DistantLinesOptions)
)
