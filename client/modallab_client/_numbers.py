"""Numbers as people read them: rounded to their uncertainty."""

import math

_PLAIN_POWERS = (-4, 5)  # powers of ten that are written without an exponent


def concise(value: float, error: float | None) -> str:
    """Return a value with its standard error in the last digits: `0.010619(7)`, `1.20(3)e6`.

    The error has one digit, and two where the first is a 1, as one digit would round it by half.
    """
    if not error or not math.isfinite(error) or not math.isfinite(value):
        return f"{value:.4g}"
    power = math.floor(math.log10(max(abs(value), error)))
    scale = 0 if _PLAIN_POWERS[0] <= power <= _PLAIN_POWERS[1] else power
    digits, last = _last_digits(error / 10.0**scale)
    if digits < 0:  # an error of tens and more: as many zeros as it has
        return f"{round(value / 10.0**scale, digits):.0f}({last * 10**-digits})" + _exponent(scale)
    return f"{value / 10.0**scale:.{digits}f}({last}){_exponent(scale)}"


def rounded(value: float, error: float | None, *, least: int = 4) -> str:
    """Return a value to two digits of its standard error; without one, to so many digits.

    Parameters
    ----------
    least
        Digits of a value without standard error, and of one that is not known as well.
    """
    if not error or not value or not math.isfinite(error) or not math.isfinite(value):
        return f"{value:.{least}g}"
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(abs(error))) + 2
    return f"{value:#.{min(max(digits, 2), 12)}g}".removesuffix(".")


def gap(value: float) -> str:
    """Return a gap, whose own scatter leaves two or three digits: `1.00`, `812`, `3.6e10`."""
    if value >= 1e4:
        mantissa, power = f"{value:.1e}".split("e")
        return f"{mantissa}e{int(power)}"
    return f"{value:.0f}" if value >= 100 else f"{value:#.3g}"


def _last_digits(error: float) -> tuple[int, int]:
    """Return the decimals that an error leaves, and its digits there."""
    decimals = -math.floor(math.log10(error))
    if round(error * 10**decimals, 9) < 2:
        decimals += 1
    last = round(error * 10.0**decimals)
    return decimals, last


def _exponent(scale: int) -> str:
    return f"e{scale}" if scale else ""
