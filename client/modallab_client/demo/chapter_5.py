"""The thesis's beam: measured with errors hidden in it, compared with its model, and the model updated."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from modallab_client import ModalLab
from modallab_client.demo import thesis
from modallab_client.demo.comparison import ComparisonTable, Line
from modallab_client.results import Correlation, IterativeUpdate, Measurement, ModalModel

Say = Callable[[str], None]

N_MODES = 8
TRUTH: tuple[Mapping[str, Any], ...] = (
    {"members": [1, 2], "property": "density", "factor": 2.0},
    {"members": [11, 12], "property": "modulus", "factor": 2.0},
)
RIG: Mapping[str, Any] = {
    "drive": "1:+Y",
    "responses": [f"{node}:+Y" for node in range(1, 22, 2)],
    "exciter": {"kind": "shaker", "armature_mass": 0.02},
    "force_transducer": {"mass_below": 0.01},
    "accelerometers": {"mass": 0.02, "roving": True},
    "analyser": {
        "frequency_max": 800.0,
        "n_lines": 401,
        "averages": 100,
        "excitation": {"kind": "periodic_random"},
    },
    "noise": {"force": 1e-2, "response": 1e-5},
}
MACROS = [list(range(first, first + 4)) for first in range(1, 21, 4)]


@dataclass(frozen=True, eq=False)
class Chapter5:
    """Test, modes and updated model of the beam."""

    model_id: str
    rig_id: str
    test: Measurement
    modes: ModalModel
    before_update: Correlation
    update: IterativeUpdate
    after_update: Correlation


def run(lab: ModalLab, *, seed: int, say: Say) -> Chapter5:
    """Return test, modes and updated model of the beam with its four wrong elements."""
    model = lab.structures.catalogue("chapter-5-beam")
    truth = lab.structures.change(model.id, TRUTH)
    rig = lab.rigs.create(**RIG)
    say("measuring 11 FRFs of the beam on the virtual rig: 100 averages, 401 lines each")
    test = lab.measurements.start(truth.id, rig.id, seed=seed).result()
    say("reading its modes (Dobson) and comparing them with the model's")
    modes = lab.modal_models.start(test.id, method="dobson", n_modes=N_MODES).result()
    before_update = lab.correlations.create(modes.id, model.id, count=N_MODES)
    say("updating the model: macro elements first, then elements")
    job = lab.updates.start(model.id, modes.id, macros=MACROS, parts=["mass", "stiffness"])
    update = job.result()
    assert isinstance(update, IterativeUpdate)
    after_update = lab.correlations.create(modes.id, update.structure_id, count=N_MODES)
    return Chapter5(model.id, rig.id, test, modes, before_update, update, after_update)


def tables(chapter: Chapter5) -> tuple[ComparisonTable, ...]:
    """Return tables 5.4 to 5.7 compared with the printed ones."""
    update = chapter.update
    measured = Line("measured, Hz", chapter.modes.frequencies, thesis.MEASURED, 1)
    frequencies, mac = update.frequencies, update.mac

    def compared(
        title: str, stage: str, printed: thesis.Row, printed_mac: thesis.Row, note: str
    ) -> ComparisonTable:
        model = Line("model, Hz", frequencies[stage], printed, 1)
        return ComparisonTable(title, (measured, model, Line("MAC", mac[stage], printed_mac, 3)), note)

    suspected = {part: len(members) for part, members in update.suspected.items()}
    return (
        ComparisonTable("Table 5.4: modes read from each FRF, scatter over the 11", _scatter(chapter.modes)),
        compared("Table 5.5: before updating", "before", thesis.MODEL, thesis.MODEL_MAC, ""),
        compared(
            "Table 5.6: after error location",
            "location",
            thesis.LOCATED,
            thesis.LOCATED_MAC,
            f"{update.iterations['location']} iterations (thesis {thesis.ITERATIONS['location']}); suspected "
            f"elements: {suspected['mass']} for mass ({thesis.SUSPECTED['mass']}), {suspected['stiffness']} "
            f"for stiffness ({thesis.SUSPECTED['stiffness']})",
        ),
        compared(
            "Table 5.7: after updating",
            "after",
            thesis.UPDATED,
            thesis.UPDATED_MAC,
            f"{update.iterations['updating']} iterations (thesis {thesis.ITERATIONS['updating']})",
        ),
    )


def _scatter(modes: ModalModel) -> tuple[Line, ...]:
    lines = []
    for name, printed in thesis.SCATTER.items():
        quantity, statistic = name.split()
        spreads = [getattr(mode, f"{quantity}_spread") for mode in modes.modes]
        scale, unit = (1.0, "Hz") if quantity == "frequency" else (100.0, "%")
        digits = 1 if quantity == "frequency" and statistic != "sd" else 2
        values = [scale * getattr(spread, statistic) for spread in spreads]
        lines.append(Line(f"{name.replace('_', ' ')}, {unit}", values, printed, digits))
    return tuple(lines)
