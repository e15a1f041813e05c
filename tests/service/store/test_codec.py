from dataclasses import fields

import numpy as np

from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.core.modal_model import DoubtfulMode, ModalModel, Mode
from modallab.store.codec import CODECS

DOFS = (Dof(1, "Y"), Dof(5, "Y", -1))


def inconsistent() -> FrequencyInconsistency:
    return FrequencyInconsistency(
        cause=InconsistencyCause.ROVING_MASS,
        shift=np.array([[-0.5, np.nan]]),
        shift_error=np.array([[0.01, np.nan]]),
        chi_square=np.array([50.0]),
        degrees=np.array([1]),
        explained=0.97,
        size=0.0201,
        size_error=3e-4,
        mode_size=np.array([0.0201]),
        mode_size_error=np.array([3e-4]),
        still_frequency=np.array([24.0]),
    )


def test_how_frequencies_wander_comes_back_and_is_served_under_its_own_names() -> None:
    given = ModalModel(
        (Mode(23.5, 0.01, np.ones(2, complex)),),
        DOFS,
        references=DOFS[1:2],
        frequency_inconsistency=inconsistent(),
    )
    codec = CODECS["modal_model"]
    body, arrays = codec.take_apart(given)
    np.testing.assert_array_equal(arrays["frequency_inconsistency_shift"], [[-0.5, np.nan]])
    found = codec.put_together(body, arrays)
    assert found.drive == DOFS[1]
    assert found.frequency_inconsistency is not None
    for field in fields(FrequencyInconsistency):
        np.testing.assert_array_equal(
            getattr(found.frequency_inconsistency, field.name), getattr(inconsistent(), field.name)
        )
    assert not found.frequency_inconsistency.shift.flags.writeable


def test_doubtful_poles_come_back_and_older_models_have_none() -> None:
    poles = (DoubtfulMode(24.5, -0.01, "residual pole with negative damping"),)
    given = ModalModel((Mode(23.5, 0.01, np.ones(2, complex)),), DOFS, doubtful=poles)
    codec = CODECS["modal_model"]
    body, arrays = codec.take_apart(given)
    assert codec.put_together(body, arrays).doubtful == poles
    del body["doubtful"]
    assert codec.put_together(body, arrays).doubtful == ()


def test_poles_beyond_the_range_come_back() -> None:
    poles, constants = np.array([4.0 + 1j, 9.0]), np.array([[1.0, 2j], [3.0, 4.0]])
    given = ModalModel(
        (Mode(23.5, 0.01, np.ones(2, complex)),),
        DOFS,
        out_of_band_eigenvalue=poles,
        out_of_band_constant=constants,
    )
    codec = CODECS["modal_model"]
    found = codec.put_together(*codec.take_apart(given))
    np.testing.assert_array_equal(found.out_of_band_eigenvalue, poles)
    np.testing.assert_array_equal(found.out_of_band_constant, constants)


def test_a_model_of_an_earlier_version_has_neither_wander_nor_drive() -> None:
    codec = CODECS["modal_model"]
    body, arrays = codec.take_apart(ModalModel((Mode(23.5, 0.01, np.ones(2, complex)),), DOFS))
    assert "frequency_inconsistency" not in body
    assert "drive" not in body
    found = codec.put_together(body, arrays)
    assert (found.frequency_inconsistency, found.drive) == (None, None)


def test_the_options_of_an_extraction_come_back() -> None:
    # a plot repeats the fits with these options
    given = ModalModel((Mode(23.5, 0.01, np.ones(2, complex)),), DOFS, options={"lines": 12, "arc": None})
    codec = CODECS["modal_model"]
    assert codec.put_together(*codec.take_apart(given)).options == given.options
