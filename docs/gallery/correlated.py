"""The picture and the numbers of docs/correlation.md: a beam 21 % too soft, one sensor turned."""

import io
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image

from docs.gallery.drawing import DPI, STYLE
from modallab.api.replies import reply_of
from modallab.core.dof import Dof
from modallab.correlation.compare import Correlation, correlate
from modallab.correlation.orthogonality import frequency_errors, orthogonality
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.expansion import expand
from modallab.fe.reduction import reduce, reduction_of
from modallab.fe.synthetic_modes import ModeNoise, exact_modes, synthetic_modes
from modallab.rig.exact import exact_frf
from modallab_client._correlation_plot import coordinates, fdac, matrix
from modallab_client.methods.correlations import correlation_of

BEAM = STRUCTURES["chapter-5-beam"]()
SENSORS = tuple(Dof(node, "Y") for node in range(1, 22, 2))
TURNED = 4  # 9:+Y
STIFFER = 1.21
COLOURS = 64
ROWS = {
    "`guyan`": ("guyan", {}),
    "`irs`": ("irs", {}),
    "`irs`, `iterations` 5": ("irs", {"iterations": 5.0}),
    "`dynamic`, `frequency` 211.287": ("dynamic", {"frequency": 211.2866}),
    "`serep`, `modes` 8": ("serep", {"modes": 8.0}),
}


def case() -> Correlation:
    """Return how a beam stiffer throughout, measured with one sensor turned, correlates with the model."""
    truth = change(BEAM, [MemberChange(tuple(range(1, 21)), MemberProperty.MODULUS, factor=STIFFER)])
    frf = exact_frf(truth, SENSORS[0], SENSORS, frequency_max=800.0, n_lines=401)
    signs = np.where(np.arange(len(SENSORS)) == TURNED, -1.0, 1.0)
    rng = np.random.default_rng(0)  # not drawn from
    modes = synthetic_modes(assemble(truth), 7, SENSORS, noise=ModeNoise(), rng=rng)
    turned = tuple(replace(mode, shape=signs * mode.shape) for mode in modes.modes)
    return correlate(
        assemble(BEAM),
        replace(modes, modes=turned),
        frf=replace(frf, values=frf.values * signs[:, None]),
    )


def draw() -> Figure:
    """Return the picture: MAC, coordinates, lines."""
    correlation = case()
    assert correlation.responses is not None
    wire: Any = reply_of(Correlation).model_validate(correlation).model_dump(mode="json")
    lines = {"fdac_freq": correlation.responses.freq, "fdac": correlation.responses.fdac}
    texts = dict.fromkeys(("id", "owner", "created", "version", "name", "comment"), "")
    resource: dict[str, Any] = texts | {"seed": None, "made_from": {}, "labels": ()}
    drawn_correlation = correlation_of(resource | wire, lines)
    assert drawn_correlation.responses is not None
    with rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(10.5, 3.6), dpi=DPI, layout="constrained")
        parts: Any = figure.subfigures(1, 3)
        left_figure, middle_figure, right_figure = parts
        axes = left_figure.subplots()
        matrix(axes, correlation.mac)
        axes.set(xlabel="mode of the model", ylabel="measured mode", title="MAC")
        upper, lower = middle_figure.subplots(2, 1, sharex=True)
        coordinates(upper, lower, drawn_correlation)
        lower.tick_params(axis="x", rotation=90)
        upper.set_title("by degree of freedom")
        axes = right_figure.subplots()
        fdac(axes, drawn_correlation.responses, "1:+Y")
        axes.set_title("FDAC")
    return figure


def png(figure: Figure) -> bytes:
    """Return a figure as a small picture, without date or program."""
    raw, small = io.BytesIO(), io.BytesIO()
    figure.savefig(raw, format="png", dpi=DPI, metadata={"Software": None})
    image = Image.open(raw).convert("RGB")
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()


def reductions() -> str:
    """Return the table of reductions to eleven of the beam's 42 DoFs, six modes."""
    system = assemble(BEAM)
    full = exact_modes(system, 6)
    full_shapes = full.shapes[[system.index(dof) for dof in SENSORS]]
    rng = np.random.default_rng(0)  # not drawn from
    measured = synthetic_modes(system, 6, SENSORS, noise=ModeNoise(), rng=rng)
    lines = [
        "| reduction | mode 1 | 2 | 3 | 4 | 5 | 6 | largest off-diagonal entry | largest shape error |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, (kind, parameters) in ROWS.items():
        reduction = reduction_of(kind, parameters)
        reduced = reduce(system, SENSORS, reduction)
        errors = " | ".join(
            _brief(error) for error in frequency_errors(reduced, full_shapes, full.frequencies)
        )
        mass = np.abs(orthogonality(full_shapes, full_shapes, reduced.mass) - np.eye(6)).max()
        shapes = expand(system, measured, reduction).model.shapes
        worst = (np.abs(shapes - full.shapes).max(axis=0) / np.abs(full.shapes).max(axis=0)).max()
        lines.append(f"| {name} | {errors} | {_brief(float(mass))} | {_brief(float(worst))} |")
    return "\n".join(lines)


def _brief(value: float) -> str:
    return "0" if abs(value) < 1e-6 else f"{value:.0e}" if abs(value) < 1e-3 else f"{value:.2g}"
