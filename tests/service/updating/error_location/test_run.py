"""Errors located by one step."""

import pytest

from modallab.core.errors import UnderdeterminedError
from modallab.updating.error_location.method import LOCATORS
from modallab.updating.error_location.run import locate
from modallab.updating.parameterisation import parameterise
from tests.service.updating.cases import BEAM, BEAM_DOFS, WRONG_BEAM, modes_of


@pytest.mark.parametrize("method", LOCATORS)
def test_coefficients_that_no_measured_number_feels_are_refused(method: str) -> None:
    # along itself the beam does not move in any mode that is measured
    with pytest.raises(UnderdeterminedError, match="no measured number moves"):
        locate(BEAM, parameterise([(1, 2), (3, 4)], ["axial"]), method, modes_of(WRONG_BEAM, 5, BEAM_DOFS))
