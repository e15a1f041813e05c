"""Plots of the demo on given axes."""

from collections.abc import Callable, Mapping
from io import BytesIO, StringIO
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import pyplot

from modallab_client import _diagnosis_plot
from modallab_client.models import ComplexArray, FloatArray
from modallab_client.results import DiagnosisCurves, Iteration, IterativeUpdate, Measurement, ModalModel
from modallab_client.settings import PLOT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WRONG = {"mass": {1, 2}, "stiffness": {11, 12}}  # members that the hidden truth changes


def frfs(axes: "Axes", test: Measurement) -> None:
    """Draw the magnitude of every FRF."""
    positive = test.freq > 0
    axes.semilogy(test.freq[positive], np.abs(test.values[positive, :, 0]), linewidth=0.8)
    axes.set(xlabel="frequency, Hz", ylabel="|inertance|, m/(s² N)", title="11 measured FRFs")


def nyquist(axes: "Axes", test: Measurement, modes: ModalModel, *, mode: int, output: int) -> None:
    """Draw one resonance in the complex plane: measured lines, and the circle of the fitted mode."""
    assert modes.modal_constants is not None
    assert modes.fitted_frequencies is not None
    assert modes.fitted_loss_factors is not None
    frequency = float(modes.fitted_frequencies[mode, output])
    eta = float(modes.fitted_loss_factors[mode, output])
    constant = complex(modes.modal_constants[mode, output])

    def resonance(freq: FloatArray) -> ComplexArray:
        eigenvalue = (2 * np.pi * frequency) ** 2 * (1 + 1j * eta)
        return np.asarray(constant / (eigenvalue - (2 * np.pi * freq) ** 2))

    near = np.abs(test.freq - frequency) < PLOT.nyquist_bandwidths * eta * frequency
    freq = test.freq[near]
    measured = test.values[near, output, 0] / -((2 * np.pi * freq) ** 2)
    # The contribution of other modes hardly changes over one resonance: it shifts the circle as a whole.
    residual = complex(np.mean(measured - resonance(freq)))
    fine = np.linspace(freq[0], freq[-1], 600)
    circle = resonance(fine) + residual
    axes.plot(1e6 * circle.real, 1e6 * circle.imag, color="C1", linewidth=1.2, label="fitted mode")
    axes.plot(1e6 * measured.real, 1e6 * measured.imag, "o", color="C0", markersize=4, label="measured lines")
    axes.set(xlabel="Re receptance, µm/N", ylabel="Im receptance, µm/N")
    axes.set_title(f"mode {mode + 1}, {frequency:.1f} Hz, at {test.outputs[output]}")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize="small")


def coefficients(axes: "Axes", update: IterativeUpdate, part: str) -> None:
    """Draw the coefficients of one part by iteration: those of the wrong elements in colour."""
    paths = _paths(update.history, part)
    located = update.iterations["location"]
    for member, values in paths.items():
        wrong = member in WRONG[part]
        style = {"color": f"C{member % 10}", "linewidth": 2.0, "zorder": 3.0} if wrong else {}
        axes.plot(range(len(values)), values, **({"color": "0.75", "linewidth": 0.9} | style))  # type: ignore[arg-type]
    for member in WRONG[part]:
        axes.plot([], [], color=f"C{member % 10}", linewidth=2, label=f"element {member} (truth: 2)")
    axes.plot([], [], color="0.75", label="other elements (truth: 1)")
    axes.axvline(located, color="0.4", linewidth=0.8, linestyle=":")
    axes.text(located, 1.01, " location | updating", ha="center", transform=axes.get_xaxis_transform())
    axes.set(xlabel="iteration", ylabel=f"{part} coefficient")
    axes.legend(fontsize="small")


def _paths(history: tuple[Iteration, ...], part: str) -> Mapping[int, list[float]]:
    """Return the coefficient of every member by iteration, from 1 at the start."""
    paths = {member: [1.0] for iteration in history for macro in iteration.macros for member in macro.members}
    for iteration in history:
        coefficients_of_step = {
            member: float(value)
            for macro, value in zip(iteration.macros, iteration.coefficients, strict=True)
            if macro.part == part
            for member in macro.members
        }
        for member, values in paths.items():
            values.append(coefficients_of_step.get(member, 1.0))
    return paths


def explained(axes: "Axes", curves: DiagnosisCurves) -> None:
    """Draw the clearest difference: measured lines of one response, predicted before and after."""
    frfs = curves.by_frf()
    output, lines = _diagnosis_plot.clearest(frfs)
    styles = {
        "before": ("C1-", "predicted, effect not known"),
        "after": ("C0--", "predicted, effect added"),
        "measured": ("k.", "measured"),
    }
    for name, (style, label) in styles.items():
        magnitude = np.abs(getattr(frfs, name)[lines, output])
        axes.semilogy(frfs.freq[lines], magnitude, style, linewidth=1.2, markersize=5, label=label)
    axes.set(xlabel="frequency, Hz", ylabel="|inertance|, m/(s² N)")
    suffix = ", held out of every fit" if frfs.held_out[output] else ""
    axes.set_title(f"response {frfs.outputs[output]}{suffix}")
    axes.legend(fontsize="small")


def single_plot(draw: "Callable[[Axes], None]", size: tuple[float, float] = (7.5, 3.6)) -> "Figure":
    """Return a figure with one drawing."""
    figure, axes = pyplot.subplots(figsize=size, layout="constrained")
    draw(axes)
    return figure


def svg(figure: "Figure") -> str:
    """Return a figure as SVG, and close it."""
    text = StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    pyplot.close(figure)
    return text.getvalue()


def overview(
    test: Measurement, modes: ModalModel, update: IterativeUpdate, curves: DiagnosisCurves, *, heading: str
) -> bytes:
    """Return one picture of all: FRFs, a resonance, the update, the diagnosis; PNG."""
    figure, axes = pyplot.subplots(2, 2, figsize=(11, 6.6), layout="constrained")
    frfs(axes[0, 0], test)
    nyquist(axes[0, 1], test, modes, mode=len(modes.modes) - 1, output=0)
    coefficients(axes[1, 0], update, "stiffness")
    explained(axes[1, 1], curves)
    figure.suptitle(heading)
    content = BytesIO()
    figure.savefig(content, format="png", dpi=80, metadata={"Software": None})
    pyplot.close(figure)
    return content.getvalue()
