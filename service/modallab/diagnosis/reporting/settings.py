"""Settings of a report: significance of what it shows, and the layout of its drawings."""

from dataclasses import dataclass

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class ReportSettings(Settings):
    """Significance of statements and of enlargements."""

    even_probability: float = setting(
        0.5, doc="probability of an effect below which the report explains why it is low", derived="even odds"
    )
    shift_significance: float = setting(
        4.0,
        unit="standard errors",
        doc="size of a mode's shift above which the shifts stand in a table",
        derived="4 sigma: chance alone exceeds it once in 16,000",
    )
    visible_difference: float = setting(
        3.0,
        unit="random errors",
        doc="difference of an FRF above which it is enlarged",
        derived="3 sigma: one of 370 by chance",
    )
    enlargement_level: float = setting(
        0.15, doc="share of the largest difference to which an enlargement extends", derived="legibility"
    )
    visible_log_ratio: float = setting(
        0.3, doc="|ln(measured / predicted)| that an axis in decibels shows", derived="2.6 dB"
    )
    largest_known_error: float = setting(
        1.0,
        doc="relative random error of an FRF from which its axis does not follow it",
        derived="100 %: where the source has no power a measured FRF is noise alone",
    )
    most_named: int = setting(
        4, unit="channels", doc="channels of one effect that are named one by one", derived="legibility"
    )
    fewest_lines: int = setting(
        10, unit="lines", doc="least lines on each side of the largest difference", derived="legibility"
    )
    most_lines: int = setting(
        60, unit="lines", doc="most lines on each side of the largest difference", derived="legibility"
    )
    band_share: int = setting(
        8,
        doc="fraction 1 / n of all lines that an enlargement shows on each side at most",
        derived="an enlargement of the whole band shows nothing new",
    )
    spectrum_gap: float = setting(
        1.5,
        doc="mean squared residual above which an auto spectrum is drawn",
        tuned="simulated tests of the suite",
    )
    poor_line: float = setting(
        3.0,
        doc="random error of a line over the median, above which the ratio plot omits it",
        derived="legibility: its bar would exceed the axis",
    )


@dataclass(frozen=True)
class DrawingSettings(Settings):
    """Layout of the drawings, in units of the SVG user space unless stated."""

    width: float = setting(480.0, doc="width of a drawing", derived="screen of a phone, half a printed page")
    bare_margin: float = setting(
        12.0,
        doc="margin below a drawing that shares its frequency axis with the next",
        derived="half a label",
    )
    tick_steps: tuple[float, ...] = setting(
        (1.0, 2.0, 5.0, 10.0), doc="tick distances times a power of ten", derived="round numbers"
    )
    curve_points: int = setting(
        400, unit="points", doc="points of a curve", derived="about one per unit of width"
    )
    least_residual: float = setting(
        1e-2, unit="random errors", doc="least residual on a logarithmic axis", derived="invisible below"
    )
    largest_error: float = setting(
        0.9,
        doc="largest relative error of |H| drawn as a band",
        derived="1 - error must be positive in decibels",
    )
    ratio_dots: int = setting(
        200, unit="lines", doc="lines in the ratio plot", derived="dots that do not overlap"
    )
    ratio_margin: float = setting(
        1.3, doc="axis over the largest difference of the ratio plot", derived="margin"
    )
    level_limits: tuple[float, ...] = setting(
        (2.0, 5.0, 15.0, 50.0),
        unit="random errors",
        doc="limits of the colours",
        derived="2 sigma, then about a factor of three each",
    )
    map_columns: int = setting(
        120, unit="cells", doc="cells of a map's row", derived="cells of 3 units are visible"
    )
    row_height: float = setting(15.0, doc="largest height of a map's row", derived="height of a label")
    map_height: float = setting(300.0, doc="largest height of all rows of a map", derived="part of a page")
    label_height: float = setting(11.0, doc="least distance of row labels", derived="height of their text")
    sketch_margin: float = setting(
        40.0, doc="margin of the sketch of a structure", derived="room for the arrow"
    )
    sketch_height: float = setting(230.0, doc="largest height of the sketch", derived="part of a page")
    label_distance: tuple[float, ...] = setting(
        (22.0, 13.0), doc="least distance of node numbers, across and down", derived="size of their text"
    )


@dataclass(frozen=True)
class TerminalSettings(Settings):
    """Layout of the summary on a terminal."""

    width: int = setting(100, unit="columns", doc="longest line", derived="usual width of a terminal")
    label_width: int = setting(
        11, unit="columns", doc="width of the labels", derived="longest label and two blanks"
    )


REPORT = ReportSettings()
DRAWING = DrawingSettings()
TERMINAL = TerminalSettings()
