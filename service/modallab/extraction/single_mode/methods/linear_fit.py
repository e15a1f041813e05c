"""Linear fit: mode and residual from one least-squares problem that is linear in its unknowns."""

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.options import DistantLinesOptions
from modallab.extraction.single_mode.lines import conclude, mode_beside_constant, one_row, scale
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)


@in_blocks
def linear_fit(freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
    """Mode and constant residual at once, from an equation linear in its three unknowns.

    `alpha = A/(lambda_r - omega^2) + R` times its denominator is
    `alpha omega^2 = lambda_r alpha + c + R omega^2`, `c = -(A + R lambda_r)`. The errors of the lines come
    multiplied by the denominator, which the weights allow for and which is renewed with every solution.

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
    return conclude(lines, *mode_beside_constant(lines))


def linear_fit_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray
) -> dict[str, FloatArray | ComplexArray]:
    """The two sides of the equation: `alpha omega^2`, and the sum of three terms fitted to it."""
    lines, x, points = one_row(freq, frf, weight)
    eigenvalue, constant, residual = mode_beside_constant(lines)
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
