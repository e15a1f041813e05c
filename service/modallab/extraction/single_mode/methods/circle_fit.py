"""Circle fit: circle through the Nyquist plot of one mode, swept at a known rate."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.numerics import SAFE_SQUARED_DIVISOR
from modallab.core.options import option
from modallab.extraction.options import MIN_LINES, SingleModeOptions
from modallab.extraction.single_mode.lines import Lines, physical_fits, scale, single_window
from modallab.extraction.single_mode.method import (
    EXTRACTION_METHODS,
    ModeFits,
    SingleModeMethod,
    in_blocks,
)
from modallab.extraction.single_mode.settings import CIRCLE_FIT


@dataclass(frozen=True)
class CircleFitOptions(SingleModeOptions):
    """Options of the circle fit."""

    arc: float | None = option(
        None,
        unit="degree",
        lower=180.0,
        upper=360.0,
        doc="angle of the circle, centred on resonance, whose lines are fitted; None: the whole circle",
    )


@in_blocks
def circle_fit(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray, *, arc: float | None = None
) -> ModeFits:
    """Circle through the lines, resonance at the largest sweep rate, damping from every pair of lines.

    With theta the angle from resonance, `tan(theta/2) = (1 - (omega/omega_r)^2)/eta`. Resonance is where
    d(theta)/d(omega^2) is greatest; each pair of lines, a above and b below it, gives
    `eta = (omega_a^2 - omega_b^2) / (omega_r^2 (tan|theta_a/2| + tan|theta_b/2|))`, and
    `A = 2 i eta omega_r^2 (z_res - centre)`. The residual is the displacement of the circle from the origin.
    `quality` contains the variation of radius and damping, both in %.

    Parameters
    ----------
    freq, frf, weight
        As `ExtractionMethod`.
    arc
        Angle about resonance, in degrees, whose lines are fitted; None for all lines. A window keeps all of
        its lines where those on the arc are fewer than four, or lie between the half-power points.

    References
    ----------
    Kennedy, C. C. and Pancu, C. D. P. (1947), Journal of the Aeronautical Sciences 14, 603-625;
    Ewins, D. J. (1984), Modal Testing, section 4.3.
    """
    lines = scale(freq, frf, _weight_on_arc(freq, frf, weight, arc))
    centre, radius = _fitted_circle(lines)
    spoke = lines.z - centre[:, None]
    at, resonance, running = _resonance(lines, spoke)
    half_tan = _half_tan(spoke / np.exp(1j * resonance)[:, None])
    width, variation = _damping_pairs(lines, at, half_tan)
    eigenvalue = at + 1j * np.where(running, width, -width)
    to_resonance = radius * np.exp(1j * resonance)
    radial_error = np.abs(spoke) / radius[:, None] - 1
    spread = np.sqrt((lines.weight * radial_error**2).sum(axis=1) / lines.weight.sum(axis=1))
    quality = {"radius_variation": 100 * spread, "damping_variation": 100 * variation}
    return physical_fits(lines, eigenvalue, 2j * width * to_resonance, centre - to_resonance, quality)


def _weight_on_arc(freq: FloatArray, frf: ComplexArray, weight: FloatArray, arc: float | None) -> FloatArray:
    """Return the weights (n_fits, n_lines), zero where a line is off the arc about the fitted resonance."""
    if arc is None:
        return weight
    lines = scale(freq, frf, weight)
    centre, _ = _fitted_circle(lines)
    spoke = lines.z - centre[:, None]
    _, resonance, _ = _resonance(lines, spoke)
    angle = np.angle(spoke / np.exp(1j * resonance)[:, None])
    on_arc = (weight > 0) & (np.abs(angle) <= np.radians(arc) / 2)
    # half-power points lie at a quarter of a turn: within them the lines say too little of the damping
    span = np.where(on_arc, angle, 0.0)
    enough = (on_arc.sum(axis=1) >= MIN_LINES) & (span.max(axis=1) >= np.pi / 2)
    enough &= span.min(axis=1) <= -np.pi / 2
    return np.where(on_arc | ~enough[:, None], weight, 0.0)


def circle_fit_plot(
    freq: FloatArray, frf: ComplexArray, weight: FloatArray, *, arc: float | None = None
) -> dict[str, FloatArray | ComplexArray]:
    """Return the Nyquist circle with its points, the sweep rate, and the loss factor of every pair of lines.

    `sweep_rate` is that of the angle between neighbouring lines; `damping_surface` (n_above, n_below).
    """
    weight = _weight_on_arc(freq[None], frf[None], weight[None], arc)[0]
    lines, x, points = single_window(freq, frf, weight)
    centre, radius = _fitted_circle(lines)
    spoke = lines.z - centre[:, None]
    at, resonance, _ = _resonance(lines, spoke)
    rotated = spoke / np.exp(1j * resonance)[:, None]
    offset, half_tan = (lines.x - at[:, None])[0], _half_tan(rotated)[0]
    upper, lower = np.flatnonzero(offset > 0), np.flatnonzero(offset < 0)
    width = (offset[upper, None] - offset[lower]) / _not_zero(half_tan[upper, None] + half_tan[lower])
    turn = np.angle(rotated[0, 1:] * rotated[0, :-1].conj())
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, CIRCLE_FIT.plot_points))
    size = lines.size
    stiffness = lines.centre + lines.half * at
    return {
        "x": x,
        "points": points,
        "centre": size * centre,
        "radius": size * radius,
        "circle": size * (centre + radius * circle),
        "resonance": size * (centre + radius * np.exp(1j * resonance)),
        "x_resonance": stiffness,
        "angle": np.angle(rotated[0]),
        "x_sweep": (x[1:] + x[:-1]) / 2,
        "sweep_rate": turn / np.diff(x),
        "x_above": x[upper],
        "x_below": x[lower],
        "damping_surface": lines.half * width / stiffness,
    }


def _fitted_circle(lines: Lines) -> tuple[ComplexArray, FloatArray]:
    """Return centre and radius, (n_fits,), by least squares on |z - c|^2 = R^2, then on the distances."""
    w = lines.weight / lines.weight.sum(axis=1, keepdims=True)
    mean = (w * lines.z).sum(axis=1)
    z = lines.z - mean[:, None]
    square = np.abs(z) ** 2
    # normal equations of 2 Re(conj(c) z) + k = |z|^2 about the mean of z, where k separates
    xx, yy = (w * z.real**2).sum(axis=1), (w * z.imag**2).sum(axis=1)
    xy = (w * z.real * z.imag).sum(axis=1)
    px, py = (w * z.real * square).sum(axis=1), (w * z.imag * square).sum(axis=1)
    determinant = _not_zero(xx * yy - xy**2)
    centre = ((yy * px - xy * py) + 1j * (xx * py - xy * px)) / (2 * determinant)
    radius = np.sqrt(xx + yy + np.abs(centre) ** 2)
    for _ in range(CIRCLE_FIT.gauss_newton_steps):
        centre, radius = _geometric_step(z, w, centre, radius)
    return centre + mean, radius


def _geometric_step(
    z: ComplexArray, w: FloatArray, centre: ComplexArray, radius: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Return centre and radius after one Gauss-Newton step on the distances from the circle."""
    spoke = z - centre[:, None]
    length = np.abs(spoke)
    unit = spoke / _not_zero(length)
    u = unit - (w * unit).sum(axis=1, keepdims=True)
    distance = length - radius[:, None]
    xx, yy = (w * u.real**2).sum(axis=1), (w * u.imag**2).sum(axis=1)
    xy = (w * u.real * u.imag).sum(axis=1)
    px, py = (w * u.real * distance).sum(axis=1), (w * u.imag * distance).sum(axis=1)
    determinant = _not_zero(xx * yy - xy**2)
    step = ((yy * px - xy * py) + 1j * (xx * py - xy * px)) / determinant
    # a step longer than the radius means that the lines hardly show a circle: it is limited
    step *= np.minimum(1, radius / _not_zero(np.abs(step)))
    centre = centre + step
    return centre, (w * np.abs(z - centre[:, None])).sum(axis=1)


def _resonance(lines: Lines, spoke: ComplexArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return the place of the largest sweep rate, the angle there, and whether the sweep is clockwise.

    One mode maps the line x onto the circle by `tan(angle/2) = (a x + b)/(c x + 1)`, with angles measured
    from the line next to x = 0. That is linear in a, b, c; the sweep rate `2 (a - bc)/((ax + b)^2 + (cx +
    1)^2)` is greatest at the minimum of its denominator. Positive damping makes the sweep clockwise.
    """
    nearest = np.argmin(np.where(lines.weight > 0, np.abs(lines.x), np.inf), axis=1)
    origin = spoke[np.arange(len(spoke)), nearest]
    half_angle = np.angle(spoke * origin.conj()[:, None]) / 2
    cosine, sine = np.cos(half_angle), np.sin(half_angle)
    columns = (cosine * lines.x, cosine, -sine * lines.x)
    weight = lines.weight
    for _ in range(2):  # the denominator scales each row's error and is known after the first fit
        a, b, c = _solve(columns, sine, weight)
        sweep = (a[:, None] * lines.x + b[:, None]) ** 2 + (c[:, None] * lines.x + 1) ** 2
        weight = lines.weight / _not_zero(sweep)
    at = -(a * b + c) / _not_zero(a**2 + c**2)
    resonance = 2 * np.arctan2(a * at + b, c * at + 1) + np.angle(origin)
    return at, resonance, a < b * c


def _solve(
    columns: tuple[FloatArray, FloatArray, FloatArray], right: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the weighted least-squares solution of the three unknowns of each row, by cofactors."""
    p, q, r = (weight * column for column in columns)
    u, v, w = columns
    pp, pq, pr = (p * u).sum(axis=1), (p * v).sum(axis=1), (p * w).sum(axis=1)
    qq, qr, rr = (q * v).sum(axis=1), (q * w).sum(axis=1), (r * w).sum(axis=1)
    f, g, h = (p * right).sum(axis=1), (q * right).sum(axis=1), (r * right).sum(axis=1)
    ff, fg, fh = qq * rr - qr**2, pr * qr - pq * rr, pq * qr - pr * qq
    gg, gh, hh = pp * rr - pr**2, pq * pr - pp * qr, pp * qq - pq**2
    determinant = pp * ff + pq * fg + pr * fh
    determinant = np.where(np.abs(determinant) < SAFE_SQUARED_DIVISOR, np.inf, determinant)
    return (
        (ff * f + fg * g + fh * h) / determinant,
        (fg * f + gg * g + gh * h) / determinant,
        (fh * f + gh * g + hh * h) / determinant,
    )


def _damping_pairs(lines: Lines, at: FloatArray, half_tan: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean of eta omega_r^2 over all pairs, on the scale of x, and its relative deviation."""
    offset = lines.x - at[:, None]
    # an error e of an angle moves tan(theta/2) by e (1 + tan^2)/2
    noise = (1 + half_tan**2) ** 2 / np.where(lines.weight > 0, lines.weight, 1.0)
    upper = (lines.weight > 0) & (offset > 0)
    lower = (lines.weight > 0) & (offset < 0)
    pairs = upper[:, :, None] & lower[:, None, :]
    tangents = np.where(pairs, half_tan[:, :, None] + half_tan[:, None, :], 1.0)
    width = np.where(pairs, offset[:, :, None] - offset[:, None, :], 0.0) / _not_zero(tangents)
    trust = np.where(pairs, (tangents / _not_zero(width)) ** 2, 0.0)
    trust = trust / (noise[:, :, None] + noise[:, None, :])
    total = _not_zero(trust.sum(axis=(1, 2)))
    mean = (trust * width).sum(axis=(1, 2)) / total
    square = (trust * (width - mean[:, None, None]) ** 2).sum(axis=(1, 2)) / total
    return mean, np.sqrt(square) / _not_zero(mean)


def _half_tan(rotated: ComplexArray) -> FloatArray:
    """Return tan|theta/2| of the angle theta of complex numbers, without a branch cut."""
    size = np.abs(rotated)
    values = np.abs(rotated.imag) / _not_zero(size + rotated.real)
    return np.minimum(values, CIRCLE_FIT.largest_half_tangent)


def _not_zero(values: FloatArray) -> FloatArray:
    """Return the values, with zeros replaced by the smallest admissible divisor."""
    return np.where(np.abs(values) < SAFE_SQUARED_DIVISOR, SAFE_SQUARED_DIVISOR, values)


EXTRACTION_METHODS.register("circle_fit")(
    SingleModeMethod(fit=circle_fit, plot=circle_fit_plot, options=CircleFitOptions, fit_options=("arc",))
)
