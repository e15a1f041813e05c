"""Settings of the client: waiting for the service, and plots."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ConnectionSettings:
    """Waiting for a service and its jobs, in seconds."""

    start_polling: float = 0.05
    """s, between two looks at a service that starts"""
    event_timeout: float = 30.0
    """s without an event after which the connection counts as broken; the service sends one every 15 s"""
    outage: float = 60.0
    """s that an absent service is waited for: it continues its jobs when it is back"""
    polling: tuple[float, ...] = (0.05, 0.1, 0.2, 0.5, 1.0)
    """s, between two looks at a job whose event stream keeps breaking"""
    retry_pauses: tuple[float, ...] = (0.2, 0.4, 0.8, 1.6)
    """s, before a request is repeated; a service that restarts is back within about three seconds"""
    longest_pause: float = 30.0
    """s; a service that asks for a longer pause is reported to the caller as busy"""


@dataclass(frozen=True)
class EmbeddedSettings:
    """Start and end of an embedded service."""

    start_timeout: float = 60.0
    """s, for a cold start on a slow disk"""
    stop_timeout: float = 20.0
    """s, more than the guardian grants the service"""
    exit_notice: float = 1.5
    """s that the guardian may take to notice that the service has died, and to clear up"""
    log_lines: int = 40
    """last lines of the log in an error message"""


@dataclass(frozen=True)
class PlotSettings:
    """Legends, tick labels and colour ranges of plots."""

    margin: float = 0.15
    """share of the height that stays free beside the outermost values"""
    legend_curves: int = 12
    """curves up to which a plot has a legend"""
    legend_width: int = 44
    """characters of a line of a legend with reasons"""
    horizontal_labels: int = 16
    """bars up to which their names stand side by side"""
    labelled_ticks: int = 40
    """names of DoFs on an axis, about"""
    annotated_modes: int = 12
    """modes up to which every value of a matrix is written into it"""
    annotation_floor: float = 0.005
    """smallest value written into a matrix of values from 0 to 1: less rounds to .00"""
    surface_range: float = 0.01
    """smallest colour range of a damping surface, relative to the loss factor"""
    nyquist_bandwidths: float = 8.0
    """half-power bandwidths on each side of a resonance in a Nyquist plot of the demo"""


@dataclass(frozen=True)
class ShapePlotSettings:
    """Pictures of structures and mode shapes."""

    size: float = 0.12
    """largest motion over the diagonal of the structure"""
    margin: float = 0.05
    """share of a side that stays free beside the structure"""
    frames: int = 24
    """pictures of one cycle"""
    rate: int = 20
    """pictures in a second"""
    numbered_nodes: int = 24
    """nodes with their numbers, about"""
    hold: float = 1e-9
    """1/m, spring to the ground of nodes that are connected to none whose motion is known"""


@dataclass(frozen=True)
class DiagnosisPlotSettings:
    """Plots of a diagnosis."""

    levels: tuple[float, ...] = (0.0, 2.0, 5.0, 15.0, 50.0, 1e9)
    """random errors at which the colour changes"""
    significant: float = 3.0
    """random errors beyond which a difference is enlarged"""
    flank: float = 0.15
    """share of the largest difference at which the enlarged range ends"""
    fewest_lines: int = 10
    """lines on each side of the largest difference, at least"""
    most_lines: int = 60
    """lines on each side of the largest difference, at most"""
    visible_difference: float = 0.3
    """|ln(measured / predicted)| that curves of an FRF show"""
    largest_error: float = 3.0
    """median random errors beyond which a line is left out of a plotted ratio"""
    smallest_gap: float = 0.1
    """where the axis of gaps begins"""


CONNECTION = ConnectionSettings()
EMBEDDED = EmbeddedSettings()
PLOT = PlotSettings()
SHAPE_PLOT = ShapePlotSettings()
DIAGNOSIS_PLOT = DiagnosisPlotSettings()
