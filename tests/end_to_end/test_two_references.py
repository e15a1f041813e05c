"""Two modes at one frequency, from a universal file with FRFs of two drive points, by client and service."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import pyuff

from modallab.core.arrays import FloatArray
from modallab_client import ModalLab
from tests.service.extraction.several_references import DOFS, FREQ, LOSS, PAIR, SHAPES, driven, exact

DIRECTION_Y = 2
INERTANCE = 12  # numerator of dataset 58: acceleration


@pytest.fixture(scope="module")
def lab() -> Iterator[ModalLab]:
    with ModalLab.embedded() as here:
        yield here


def written(path: Path, drives: tuple[int, ...]) -> Path:
    """Return a file as another laboratory's program writes it."""
    file = pyuff.UFF(str(path))
    values = driven(0.0, drives).frf.values
    for j, dof in enumerate(DOFS):
        for k, drive in enumerate(drives):
            dataset = pyuff.prepare_58(
                func_type=4,
                rsp_node=dof.node,
                rsp_dir=DIRECTION_Y,
                ref_node=DOFS[drive].node,
                ref_dir=DIRECTION_Y,
                data=values[:, j, k],
                x=FREQ,
                id1="frf",
                rsp_ent_name="plate",
                ref_ent_name="plate",
                abscissa_spacing=1,
                ordinate_spec_data_type=INERTANCE,
                orddenom_spec_data_type=13,
            )
            file.write_sets(dataset, "add")
    return path


def noise_of_mobility() -> FloatArray:
    """(12,) rms of the noise over that of the FRF, both as mobility."""
    above = FREQ > 0
    measured = driven(0.0).frf.values[above] / FREQ[above, None, None]
    noise = measured - exact(0.0, (0, 1))[above] / FREQ[above, None, None]
    ratio = np.linalg.norm(noise, axis=0) / np.linalg.norm(measured, axis=0)
    return np.asarray(ratio.ravel())


def test_a_pair_at_one_frequency_is_seen_from_two_drive_points_and_not_from_one(
    lab: ModalLab, tmp_path: Path
) -> None:
    found = {}
    for drives in ((0,), (0, 1)):
        test = lab.measurements.upload(written(tmp_path / f"{len(drives)}.uff", drives))
        found[drives] = lab.modal_models.start(test.id, method="poly_reference_lscf").result()
    one, two = found.values()
    assert (one.references, one.frfs[0]) == (("1:+Y",), "1:+Y")
    assert (two.references, two.frfs[:2]) == (("1:+Y", "2:+Y"), ("1:+Y / 1:+Y", "1:+Y / 2:+Y"))
    # 60 dB over noise: a frequency is told to some 1e-6
    np.testing.assert_allclose(one.frequencies, [30, 55, 90], rtol=1e-5)
    np.testing.assert_allclose(two.frequencies, [30, 55, 55, 90], rtol=1e-5)
    np.testing.assert_allclose(two.loss_factors, LOSS, rtol=2e-3)
    together = two.shapes[:, PAIR] @ two.shapes[:, PAIR].T
    largest = np.abs(SHAPES).max() ** 2
    np.testing.assert_allclose(together, SHAPES[PAIR].T @ SHAPES[PAIR], atol=5e-3 * largest)
    assert two.resynthesis_error is not None
    # nothing but noise is left, and of that at the lowest lines, where most of it is, residuals take a part
    assert (np.array([*two.resynthesis_error.values()]) < noise_of_mobility()).all()
    assert "coincident" in " ".join(two.modes[1].flags)
    single = lab.modal_models.start(two.measurement_id or "", method="dobson").result()
    picture = lab.modal_models.fit(single.id, mode=1, response="3:+Y", reference="2:+Y")
    assert picture.frequency == pytest.approx(30, rel=1e-4)
