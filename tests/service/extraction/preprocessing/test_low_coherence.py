"""Modes that rest on little coherence come with a warning."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.extract import extract

FREQ = np.arange(1.0, 200.0, 0.5)
DOFS = (Dof(1, "Y"), Dof(2, "Y"), Dof(3, "Y"))


@pytest.mark.parametrize("method", ["dobson", "lscf"])
@pytest.mark.parametrize(("coherence", "warned"), [(0.2, True), (0.5, False)])
def test_coherence_below_three_tenths_is_warned_of(method: str, coherence: float, warned: bool) -> None:
    eigenvalue = (2 * np.pi * 50.3) ** 2 * (1 + 0.02j)
    rng = np.random.default_rng(3)
    error = np.sqrt((1 - coherence) / (2 * 400 * coherence)) * rng.normal(size=(2, len(FREQ), 3))
    values = (1 + error[0] + 1j * error[1]) / (eigenvalue - (2 * np.pi * FREQ[:, None]) ** 2)
    frf = FrfSet(FREQ, values[:, :, None], DOFS, DOFS[:1], FrfKind.RECEPTANCE)
    model = extract(
        frf, coherence=np.full((len(FREQ), 3), coherence), averages=400.0, method=method, n_modes=1
    )
    told = [note for note in model.notes if "has lines with a coherence of" in note]
    assert len(told) == warned
    assert all("0.2" in note and "400 averages" in note for note in told)
