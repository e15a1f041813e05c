import numpy as np

from modallab.core.common_dofs import common_points, rows_at
from modallab.core.dof import Dof

DOFS = (Dof(7, "Y"), Dof(2, "Y", -1), Dof(3, "Z"), Dof(2, "Y"))


def test_dofs_are_shared_whatever_their_sense_and_come_in_order() -> None:
    assert common_points(DOFS, (Dof(2, "Y"), Dof(7, "Y", -1), Dof(9, "Y"))) == (Dof(2, "Y"), Dof(7, "Y"))
    assert common_points(DOFS, ()) == ()
    assert common_points(DOFS) == (Dof(2, "Y"), Dof(3, "Z"), Dof(7, "Y"))


def test_of_a_dof_given_twice_the_first_counts_with_its_own_sign() -> None:
    rows, signs = rows_at(DOFS, (Dof(2, "Y"), Dof(7, "Y")))
    np.testing.assert_array_equal(rows, [1, 0])
    np.testing.assert_array_equal(signs, [-1.0, 1.0])


def test_no_points_have_no_rows() -> None:
    rows, signs = rows_at(DOFS, ())
    assert rows.shape == signs.shape == (0,)
    assert rows.dtype.kind == "i"  # an index even so
