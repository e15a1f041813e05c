"""The bay and the GARTEUR frame of the thesis: chapters 2 to 4, appendix B.3."""

from typing import Any

import numpy as np

from docs.validation.bay import (
    BAY,
    DOFS,
    EARLY,
    MODES,
    N_MODES,
    fifth_iteration,
    frequencies,
    number,
    shape_rows,
)
from docs.validation.comparison import Comparison, quantity
from modallab.core.arrays import FloatArray
from modallab.correlation.mac import mac
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from tests.published.updates import FRAMES, bay_with_errors

OCR_9 = "Mode 9 of the measurement stands as 1101.1 in print; 1101.4 is compared, which the model gives."
N_DRAWS = 200


def comparisons() -> list[Comparison]:
    """Return all tables of the frames."""
    return [
        _with_errors("table_2_1", bay_with_errors("table_2_1"), "the bay, three stiffness errors", (OCR_9,)),
        _with_errors("table_3_1", bay_with_errors("table_3_1"), "the bay, errors of mass and stiffness"),
        _updated(),
        _noisy(),
        _data(),
        _garteur(),
    ]


def _with_errors(name: str, truth: Structure, title: str, notes: tuple[str, ...] = ()) -> Comparison:
    printed = FRAMES[name]
    reasons = {
        "table_2_1": (
            "482.26 is printed 482.2, cut instead of rounded",
            "",
        ),
        "table_3_1": ("", "0.9155 is printed 0.916"),
    }[name]
    found = np.diag(mac(shape_rows(truth), shape_rows(BAY)))
    return Comparison(
        number(name),
        title,
        (
            quantity("measured, Hz", printed["experimental"], frequencies(truth), 1, reasons[0]),
            quantity("model, Hz", FRAMES["table_2_1"]["analytical"], frequencies(BAY), 1),
            quantity("MAC", printed["mac"], found, 3, reasons[1]),
        ),
        "mode",
        MODES,
        notes,
    )


def _updated() -> Comparison:
    printed, result = FRAMES["table_3_4"], fifth_iteration(0.0)
    reason = "the fifth iteration here is nearer to convergence, at which measured and updated are equal"
    return Comparison(
        "Table 3.4",
        "the bay after updating",
        (
            quantity("measured, Hz", FRAMES["table_3_1"]["experimental"], result.frequencies.measured, 1),
            quantity("updated, Hz", printed["updated"], result.frequencies.after, 1, reason),
            quantity("MAC", printed["mac"], result.mac.after, 3),
        ),
        "mode",
        MODES,
        (EARLY,),
    )


def _noisy() -> Comparison:
    printed, truth = FRAMES["table_4_1"], bay_with_errors("table_3_1")
    noise = ModeNoise(eigenvalue=printed["eigenvalue_noise"], eigenvector=printed["eigenvector_noise"])
    rng, model, system = np.random.default_rng(0), shape_rows(BAY), assemble(truth)
    draws = [synthetic_modes(system, N_MODES, DOFS, noise=noise, rng=rng) for _ in range(N_DRAWS)]
    drawn = np.array([draw.frequencies for draw in draws])
    macs = np.array([np.diag(mac(draw.shapes.real, model)) for draw in draws])
    within = {
        "of frequencies": _within(printed["experimental"], drawn),
        "of MAC": _within(printed["mac"], macs),
    }
    spans = ", ".join(f"{count} of {N_MODES} {what}" for what, count in within.items())
    return Comparison(
        "Table 4.1",
        "the bay measured with random errors",
        (
            quantity(
                "measured, Hz",
                printed["experimental"],
                drawn.mean(axis=0),
                1,
                "one random draw against the mean; uniform errors of 0.5 % in eigenvalues are 0.25 % here",
            ),
            quantity("model, Hz", FRAMES["table_2_1"]["analytical"], frequencies(BAY), 1),
            quantity("MAC", printed["mac"], macs.mean(axis=0), 3, "one random draw against the mean"),
        ),
        "mode",
        MODES,
        (
            "Errors are uniform, up to 0.5 % of eigenvalues and up to 5 % of shapes. "
            f"The random numbers of 1992 are not known: the mean of {N_DRAWS} draws is compared. The printed "
            f"draw is within the range of these draws in {spans}.",
        ),
    )


def _within(printed: Any, draws: FloatArray) -> int:
    return int(((draws.min(axis=0) <= printed) & (printed <= draws.max(axis=0))).sum())


def _data() -> Comparison:
    printed = FRAMES["appendix_b_3"]
    bars = {bar.section.name: bar for bar in BAY.members}
    along = {name: sum(BAY.length(bar) for bar in BAY.members if bar.section.name == name) for name in bars}
    any_bar = BAY.members[0]
    areas = [
        quantity(f"area, {name}, m^2", printed[f"area_{name}"], bar.section.area, 3)
        for name, bar in bars.items()
    ]
    lengths = [
        quantity(f"length of a {name} side, m", printed[f"length_{name}"], along[name] / 2, 0)
        for name in ("horizontal", "vertical")
    ]
    return Comparison(
        "Table B.3",
        "data of the frames",
        (
            quantity("modulus, GPa", printed["modulus"], any_bar.material.modulus / 1e9, 0),
            quantity("second moment, m^4", printed["second_moment"], any_bar.section.second_moment, 4),
            quantity("density, kg/m^3", printed["density"], any_bar.material.density, 0),
            *areas,
            *lengths,
        ),
        notes=(
            "The exponent of the second moment is not legible; of all, only this one gives table 2.1. A side "
            "of 5 m has seven members, one of 3 m five, the diagonal seven.",
        ),
    )


def _garteur() -> Comparison:
    printed = FRAMES["garteur"]["analytical"]
    found = frequencies(STRUCTURES["garteur"](), len(printed))
    items = MODES[: len(printed)]
    return Comparison(
        "Section 3.6", "the GARTEUR frame", (quantity("model, Hz", printed, found, 1),), "mode", items
    )
