"""A round of the search."""

import pytest

import modallab.diagnosis.searching.search_round as module
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.searching.scanning import StartingPoint
from modallab.diagnosis.searching.search_round import Suspects, fit_candidates
from modallab.effects.extra_mass import ExtraMass
from tests.diagnosing import draw_measurement, predicting, rig


def test_a_place_that_the_scan_takes_for_its_neighbour_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = ExtraMass(Dof(6, "Y"), 0.1)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    starts = [StartingPoint(ExtraMass(Dof(5, "Y"), 0.08), 0.03)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    suspects = Suspects([ExtraMass(Dof(node, "Y")) for node in range(1, 10)])
    best, *others = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].at == hidden.at
    assert {4, 5, 7} == {f.effects[-1].at.node for f in others if isinstance(f.effects[-1].at, Dof)}
