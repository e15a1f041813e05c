"""The beam of the thesis and its test: chapter 5."""

import numpy as np

from docs.validation.comparison import Comparison, quantity
from modallab.correlation.mac import mac
from modallab.estimation.windows import WINDOWS
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from tests.published.noise import NOISE, bias_of_h2
from tests.published.roving import DOFS, FREQUENCIES, LOSS_FACTORS, SHAPES
from tests.published.updates import BEAM, beam_from

MODEL = STRUCTURES["chapter-5-beam"]()
MODES = tuple(str(number) for number in range(1, FREQUENCIES.shape[1] + 1))
FROM_NOISE = "the thesis fits lines to noisy FRFs, 2 Hz apart; these modes are exact"
RECORD = 256  # samples of a window
PADDING = 256  # records of zeros after it: lines between the lines


def comparisons() -> list[Comparison]:
    """Return all tables of the beam."""
    return [_data(), _windows(), _scatter(), _correlated(), _located(), _updated(), _noise()]


def _data() -> Comparison:
    printed, bar, system = BEAM["beam"], MODEL.members[0], assemble(MODEL)
    damping = MODEL.damping
    assert isinstance(damping, StructuralDamping)
    length = sum(MODEL.length(member) for member in MODEL.members)
    found = {
        "length": ("m", length, 1),
        "n_elements": ("", len(MODEL.members), 0),
        "area": ("mm^2", bar.section.area * 1e6, 0),
        "second_moment": ("mm^4", bar.section.second_moment * 1e12, 1),
        "modulus": ("GPa", bar.material.modulus / 1e9, 0),
        "density": ("kg/m^3", bar.material.density, 0),
        "n_dofs": ("", len(system.dofs), 0),
        "stiffness_damping": ("", damping.stiffness_coefficient, 3),
        "mass_damping": ("(rad/s)^2", damping.mass_coefficient, 0),
    }
    words = {"n_elements": "elements", "n_dofs": "DoFs", "stiffness_damping": "loss factor, constant part"}
    words["mass_damping"] = "loss factor times eigenvalue, other part"
    quantities = [
        quantity(
            f"{words.get(name, name.replace('_', ' '))}{', ' + unit if unit else ''}",
            printed[name],
            value,
            decimals,
        )
        for name, (unit, value, decimals) in found.items()
    ]
    return Comparison("Section 5.7", "data of the beam", tuple(quantities))


def spectrum_of(window: str) -> tuple[float, float, float]:
    """Return a window's bandwidth in lines, its highest sidelobe in dB, and their fall in dB a decade."""
    size = np.abs(np.fft.rfft(WINDOWS[window].samples(RECORD), RECORD * PADDING))
    level = 20 * np.log10(np.maximum(size / size[0], 1e-12))
    bandwidth = 2 * np.flatnonzero(level < level[0] - 10 * np.log10(2))[0] / PADDING
    peaks = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    # far from the main lobe, and from half of the sampling rate, where the lobes of both sides meet
    far = peaks[(peaks > 5 * PADDING) & (peaks < RECORD // 16 * PADDING)]
    fall = -np.polyfit(np.log10(far), level[far], 1)[0]
    return float(bandwidth), float(level[peaks].max()), float(fall)


def _windows() -> Comparison:
    quantities = []
    for window in ("rectangular", "hann"):
        bandwidth, sidelobe, fall = spectrum_of(window)
        printed = BEAM["table_5_3"][window]
        cut = {"hann": "-31.47 dB is printed -32"}.get(window, "")
        quantities += [
            quantity(f"{window}: bandwidth, lines", printed[0], bandwidth, 1),
            quantity(f"{window}: highest sidelobe, dB", printed[1], sidelobe, 0, cut),
            quantity(f"{window}: fall of sidelobes, dB a decade", printed[2], fall, 0),
        ]
    return Comparison("Table 5.3", "windows", tuple(quantities))


def _scatter() -> Comparison:
    printed, quantities = BEAM["table_5_4"], []
    for name, values, digits, prefix, unit in (
        ("frequency", FREQUENCIES, (1, 1, 1, 2), "", "Hz"),
        ("loss factor", 100 * LOSS_FACTORS, (2, 2, 2, 2), "loss_factor_", "%"),
    ):
        found = {
            "min": values.min(axis=0),
            "max": values.max(axis=0),
            "mean": values.mean(axis=0),
            "sd": values.std(axis=0, ddof=1),
        }
        quantities += [
            quantity(
                f"{name}, {kind}, {unit}",
                printed[prefix + kind],
                found[kind],
                decimals,
                "" if (name, kind) == ("frequency", "min") else FROM_NOISE,
            )
            for kind, decimals in zip(found, digits, strict=True)
        ]
    note = (
        "Frequencies scatter because the accelerometer's mass moves with it over eleven positions. Exact "
        "loss factors hardly do, so the printed scatter is one of the extraction. Table 5.5 prints 62.5 for "
        "the mean of mode 2. A digit of the smallest loss factor of mode 2 is not legible; 0.54 is compared."
    )
    return Comparison("Table 5.4", "modes of a roving test", tuple(quantities), "mode", MODES, (note,))


def _correlated() -> Comparison:
    printed, system = BEAM["table_5_5"], assemble(MODEL)
    basis = system.modes().elastic(len(MODES))
    found = np.diag(mac(SHAPES, system.selection(DOFS).T @ basis.shapes.real))
    return Comparison(
        "Table 5.5",
        "the roving test and the model",
        (
            quantity("measured, Hz", printed["experimental"], FREQUENCIES.mean(axis=0), 1),
            quantity("model, Hz", printed["analytical"], basis.frequencies, 1),
            quantity("MAC", printed["mac"], found, 3, FROM_NOISE),
        ),
        "mode",
        MODES,
    )


def _located() -> Comparison:
    printed, result = BEAM["table_5_6"], beam_from("loaded")
    suspects = {part: len(numbers) for part, numbers in result.suspected.items()}
    note = (
        f"Iterations: {printed['iterations']} printed, {result.iterations['location']} here. Suspected "
        f"members: {printed['suspected_mass']} by mass and {printed['suspected_stiffness']} by stiffness "
        f"printed, {suspects['mass']} and {suspects['stiffness']} here."
    )
    return Comparison(
        "Table 5.6",
        "the beam after the location stage",
        (
            quantity("measured, Hz", BEAM["table_5_5"]["experimental"], result.frequencies.measured, 1),
            quantity("located, Hz", printed["located"], result.frequencies.location, 1, FROM_NOISE),
            quantity("MAC", printed["mac"], result.mac.location, 3, FROM_NOISE),
        ),
        "mode",
        MODES,
        (note,),
    )


def _updated() -> Comparison:
    printed, result = BEAM["table_5_7"], beam_from("loaded")
    reason = (
        "masses on the structure make the measured modes inconsistent, so that no model has them all; the "
        "compromise is one of exact modes here, in print one of modes from noisy FRFs"
    )
    count = result.iterations["updating"]
    note = f"Iterations: {printed['iterations']} printed, {count} to convergence here."
    return Comparison(
        "Table 5.7",
        "the beam after updating",
        (
            quantity("measured, Hz", BEAM["table_5_5"]["experimental"], result.frequencies.measured, 1),
            quantity("updated, Hz", printed["updated"], result.frequencies.after, 1, reason),
            quantity("MAC", printed["mac"], result.mac.after, 3, reason),
        ),
        "mode",
        MODES,
        (note,),
    )


def _noise() -> Comparison:
    freq, bias = bias_of_h2(NOISE["spacing"], response=NOISE["response_noise"])
    near = 100 * bias[(freq >= NOISE["band"][0]) & (freq <= NOISE["band"][1])]
    least, most = NOISE["h2_bias"]
    return Comparison(
        "Section 5.7.3",
        "bias of H2 by noise in the response, mode 5",
        (
            quantity("least bias from 304 to 312 Hz, %", least, near.min(), 2),
            quantity("most bias from 304 to 312 Hz, %", most, near.max(), 1),
        ),
    )
