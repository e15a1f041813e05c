"""The pictures and the numbers of docs/extraction: one mode of a beam, read by every method."""

import io
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot, rc_context
from matplotlib.figure import Figure
from PIL import Image

from docs.gallery.drawing import STYLE
from modallab.api.modal_models.fits import chart_reply, fit_reply
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section
from modallab.fe.synthetic_modes import exact_modes
from modallab.jobs.extracting import picture_of
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab_client import _plots
from modallab_client._read import read_as
from modallab_client.methods.extraction import fit_of
from modallab_client.results import StabilisationChart

FOLDER = Path(__file__).parents[1] / "extraction"
METHODS = (*EXTRACTION_METHODS, *GLOBAL_METHODS)
MODE, RESPONSE = 3, Dof(9, "Y")  # counted from 1
LOSS = 0.02
DPI, COLOURS = 72, 128
POINTS = 400

BEAM = beam(
    length=1.5,
    n_elements=20,
    section=Section(area=5e-4, second_moment=4.1667e-9),
    material=Material(modulus=2.09e11, density=7800.0),
    damping=StructuralDamping(stiffness_coefficient=LOSS),
)
RIG = RigSetup(
    drives=(Dof(1, "Y"),),
    responses=tuple(Dof(node, "Y") for node in range(1, 22, 4)),
    analyser=Analyser(frequency_max=800.0, n_lines=1601, averages=100),
    noise=Noise(3e-3, 3e-3),
)


@lru_cache(maxsize=1)
def test_of_the_beam() -> Measurement:
    """Return FRFs of six points with noise."""
    return measure(BEAM, RIG, route=Route.DRAWN, rng=np.random.default_rng(0))


@lru_cache(maxsize=16)
def model(method: str) -> ModalModel:
    """Return the eight modes that a method reads."""
    test = test_of_the_beam()
    return extract(
        test.frf,
        coherence=test.coherence,
        averages=test.averages,
        method=method,
        n_modes=8,
        estimator=test.setup.analyser.estimator,
    )


def numbers(method: str) -> str:
    """Return a table of what the method reads of one mode, beside the truth."""
    mode = model(method).modes[MODE - 1]
    truth = exact_modes(assemble(BEAM), MODE).frequencies[MODE - 1]
    rows = [(mode.frequency, mode.standard_errors.get("frequency"), truth, "frequency, Hz", 3)]
    rows += [(mode.loss_factor, mode.standard_errors.get("loss_factor"), LOSS, "loss factor", 5)]
    lines = [f"| mode {MODE} | estimate | standard error | true |", "|---|---:|---:|---:|"]
    for value, error, true, name, digits in rows:
        error_text = "-" if error is None else f"{error:.1g}"
        lines.append(f"| {name} | {value:.{digits}f} | {error_text} | {true:.{digits}f} |")
    return "\n".join(lines)


def draw(method: str) -> Figure:
    """Return the picture of a method: one fit, or its stabilisation chart."""
    test, modes = test_of_the_beam(), model(method)
    pyplot.switch_backend("agg")
    with rc_context(STYLE | {"axes.grid": False}):
        axes: Any
        if method in GLOBAL_METHODS:
            chart = chart_reply(modes, test, POINTS).model_dump(mode="json")
            axes = _plots.chart(read_as(StabilisationChart, chart))
        else:
            fit = fit_reply(picture_of(test, modes, MODE, RESPONSE), MODE, RESPONSE)
            axes = _plots.fit(fit_of(fit.model_dump(mode="json")))[0]
        figure: Figure = axes.figure
    pyplot.close(figure)
    return figure


def png(figure: Figure) -> bytes:
    """Return a figure as a small picture, without date or program."""
    raw, small = io.BytesIO(), io.BytesIO()
    figure.savefig(raw, format="png", dpi=DPI, metadata={"Software": None})
    image = Image.open(raw).convert("RGB")
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(small, format="png", optimize=True)
    return small.getvalue()


def write(folder: Path = FOLDER) -> None:
    """Write the pictures of all methods, and their numbers into the pages."""
    for method in METHODS:
        (folder / f"{method}.png").write_bytes(png(draw(method)))
        page = folder / f"{method}.md"
        text = page.read_text(encoding="utf-8")
        start = text.index(f"| mode {MODE} |")
        page.write_text(text[:start] + numbers(method) + text[text.index("\n\n", start) :], encoding="utf-8")
