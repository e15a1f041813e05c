"""The client and the service together, as users have them."""

import asyncio
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab_client import AsyncModalLab, ModalLab, errors

# The example of the contract, a script like any user's: no main guard, nothing set up.
EXAMPLE = """
from modallab_client import ModalLab

with ModalLab.embedded() as lab:                      # starts the service beside this process, nothing to set up
    beam = lab.structures.catalogue("chapter-5-beam")
    truth = lab.structures.change(beam.id, members=[7], property="modulus", factor=1.3)
    rig = lab.rigs.create(drive="1:+Y", responses=[f"{n}:+Y" for n in range(1, 22, 2)])
    test = lab.measurements.start(truth.id, rig.id, seed=1).result()
    print(test.freq.shape, test.values.shape, test.coherence.min())
    modes = lab.modal_models.start(test.id, method="dobson", n_modes=8).result()
    print(modes.table())                              # frequency, loss factor, min, max, mean, sd
    update = lab.updates.start(beam.id, modes.id, method="inverse_eigensensitivity").result(on_progress=print)
    found = lab.diagnoses.start(beam.id, test.id).result()
    print(found.verdict, found.steps[0].effect.kind, found.steps[0].gap_before, found.steps[0].gap_after)
"""  # noqa: E501


SECTION = {"area": 5e-4, "second_moment": 4.1667e-9}
STEEL = {"modulus": 2.09e11, "density": 7800.0}


def test_the_example_of_the_contract_runs_as_it_stands(tmp_path: Path) -> None:
    script = tmp_path / "example.py"
    script.write_text(EXAMPLE)
    run = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=600
    )
    assert run.returncode == 0, run.stderr
    first, *rest = run.stdout.splitlines()
    shapes = re.fullmatch(r"\((\d+),\) \((\d+), 11, 1\) (0\.\d+|1\.0)", first)
    assert shapes is not None, first
    assert shapes[1] == shapes[2]
    assert sum("frequency Hz" in line for line in rest) == 8
    assert any(re.match(r"[01]\.\d+ \S", line) for line in rest), "print was told the progress"
    verdict, kind, before, after = rest[-1].split()
    assert (verdict, kind) == ("explained", "stiffness_error")
    assert float(before) > 1e6  # noise-free: the hidden 30 % stand far above the numerical floor
    assert float(after) < 1.5


@pytest.fixture(scope="module")
def here() -> Iterator[ModalLab]:
    """Yield a lab with a service of its own, for all tests of this file."""
    with ModalLab.embedded() as lab:
        yield lab


def test_what_is_kept_in_a_folder_is_there_the_next_time(tmp_path: Path) -> None:
    with ModalLab.embedded(tmp_path) as lab:
        beam = lab.structures.catalogue("chapter-5-beam")
    with ModalLab.embedded(tmp_path) as lab:
        assert lab.structures.get(beam.id) == beam
        assert [entry.id for entry in lab.structures.list()] == [beam.id]


def test_a_measurement_goes_out_and_comes_back_with_await(here: ModalLab) -> None:
    async def talk() -> None:
        async with AsyncModalLab(here.base_url) as lab:
            beam = await lab.structures.beam(length=1.5, n_elements=6, section=SECTION, material=STEEL)
            rig = await lab.rigs.create(drive="1:+Y", responses=["1:+Y", "7:+Y"], analyser={"n_lines": 201})
            job = await lab.measurements.start(beam.id, rig.id, route="expected")
            test = await job.result(timeout=120)
            assert test.rig_id == rig.id
            assert (await lab.jobs.get(job.id)).state == "succeeded"
            back = await lab.measurements.import_npz(
                rig.id,
                freq=test.freq,
                values=test.values,
                outputs=test.outputs,
                inputs=test.inputs,
                kind=test.kind,
            )
            np.testing.assert_array_equal(back.values, test.values)
            assert len((await lab.measurements.curves(test.id, points=20)).curves) == 2
            other = await lab.measurements.get(test.id, kind="receptance")
            assert (other.kind, len(other.freq)) == ("receptance", 200)
            assert other.notes == ("inertance at 0 Hz has no receptance: that line is left out",)
            curves = await lab.measurements.curves(test.id, kind="receptance")
            assert (curves.kind, curves.notes) == ("receptance", other.notes)
            exact = await lab.structures.frf(
                beam.id, drive="1:+Y", responses=["1:+Y", "7:+Y"], kind="receptance", n_lines=201
            )
            # no noise, no leakage, no masses: the same sum of modes
            np.testing.assert_allclose(exact.values, other.values, rtol=1e-9)
            for file in (
                await lab.measurements.uff(test.id, kind="mobility"),
                await lab.measurements.hdf5(test.id, kind="mobility"),
                await lab.measurements.thesis(test.id, decimals=16, kind="mobility"),
            ):
                assert (await lab.measurements.upload(file, rig.id)).kind == "mobility"
            assert (await lab.measurements.truth(test.id)).structure_id == beam.id
            log = await lab.measurements.log(test.id)
            same = await lab.rigs.create(**log.rig)
            assert (same.responses, same.analyser) == (rig.responses, rig.analyser)

    asyncio.run(talk())


def test_the_example_is_the_same_with_await(here: ModalLab) -> None:
    async def talk() -> None:
        async with AsyncModalLab(here.base_url) as lab:
            beam = await lab.structures.catalogue("chapter-5-beam")
            truth = await lab.structures.change(beam.id, members=[7], property="modulus", factor=1.3)
            rig = await lab.rigs.create(drive="1:+Y", responses=[f"{n}:+Y" for n in range(1, 22, 2)])
            test = await (await lab.measurements.start(truth.id, rig.id, seed=1)).result()
            modes = await (await lab.modal_models.start(test.id, method="dobson", n_modes=8)).result()
            pairs = [[n, n + 1] for n in range(1, 20, 2)]
            job = await lab.updates.start(beam.id, modes.id, macros=pairs, parts=["stiffness"])
            update = await job.result()
            # 1 %: single-mode fits neglect how the modes beside them curve, which leaves 0.2 % here
            assert update.coefficients["stiffness"][7] == pytest.approx(1.3, rel=0.01)
            corrected = await lab.correlations.create(modes.id, update.structure_id or "", count=8)
            assert corrected.pairs == tuple((mode, mode) for mode in range(1, 9))
            assert [entry.id for entry in await lab.updates.list()] == [update.id]
            assert "dobson" in [entry.kind for entry in await lab.catalog.extraction_methods()]
            assert len((await lab.modal_models.select(modes.id, merge=[[1, 2]])).modes) == 7

    asyncio.run(talk())


def test_a_direct_update_gives_matrices(here: ModalLab) -> None:
    beam = here.structures.catalogue("chapter-5-beam")
    truth = here.structures.change(beam.id, members=[11], property="modulus", factor=1.3)
    dofs = [f"{n}:+Y" for n in range(1, 22, 2)]
    modes = here.structures.synthetic_modes(truth.id, count=5, dofs=dofs)
    update = here.updates.start(beam.id, modes.id, method="baruch", completion="guyan").result()
    assert update.direct is not None
    assert update.converged == (update.direct.reproduced is not None and update.direct.reproduced < 1e-6)
    np.testing.assert_allclose(update.frequencies["after"], update.frequencies["measured"], rtol=1e-6)
    made = here.updates.matrices(update.id)
    assert made.dofs == tuple(dofs)
    assert made.stiffness is not None
    assert made.stiffness.shape == (11, 11)


def test_what_is_wrong_comes_back_as_its_class(here: ModalLab) -> None:
    beam = here.structures.catalogue("chapter-5-beam")
    here.structures.change(beam.id, members=[7], property="modulus", factor=1.3)
    elsewhere = here.rigs.create(drive="99:+Y", responses=["1:+Y"])
    with pytest.raises(errors.UnknownDofError, match="99"):
        here.measurements.start(beam.id, elsewhere.id)
    with pytest.raises(errors.InvalidInputError, match="nonsense"):
        here.request("POST", "/v1/structures", json={"kind": "catalogue", "name": "bay", "nonsense": 1})
    with pytest.raises(errors.ConflictError):
        here.structures.delete(beam.id)  # another was made from it
    with pytest.raises(errors.NotFoundError):
        here.diagnoses.get("none")


def test_work_that_is_not_wanted_any_more_stops(here: ModalLab) -> None:
    beam = here.structures.catalogue("chapter-5-beam")
    analyser = {"n_lines": 6401, "averages": 5000}  # minutes of work
    rig = here.rigs.create(drive="1:+Y", responses=["1:+Y", "11:+Y", "21:+Y"], analyser=analyser)
    job = here.measurements.start(beam.id, rig.id)
    with pytest.raises(errors.JobTimeoutError):
        job.result(timeout=0.5)
    job.cancel()
    with pytest.raises(errors.JobFailedError) as caught:
        job.result(timeout=60)
    assert caught.value.code == "cancelled"
    assert job.status().state == "cancelled"


def test_modes_go_in_and_out_as_they_are(here: ModalLab) -> None:
    beam = here.structures.catalogue("chapter-5-beam")
    dofs = ["1:+Y", "11:+Y", "21:+Y"]
    modes = here.structures.synthetic_modes(beam.id, dofs=dofs, count=3)
    assert modes.dofs == tuple(dofs)
    again = here.modal_models.import_(
        frequencies=modes.frequencies,
        loss_factors=modes.loss_factors,
        shapes=modes.shapes,
        dofs=modes.dofs,
    )
    np.testing.assert_array_equal(again.shapes, modes.shapes)
    agreement = here.correlations.create(again.id, beam.id)
    assert agreement.pairs == ((1, 1), (2, 2), (3, 3))
    assert "extra_mass" in [entry.kind for entry in here.catalog.effects()]


def test_modes_are_correlated_in_mass_and_carried_to_all_points(here: ModalLab) -> None:
    beam = here.structures.catalogue("chapter-5-beam")
    dofs = [f"{node}:+Y" for node in range(1, 22, 2)]
    modes = here.structures.synthetic_modes(beam.id, dofs=dofs, count=4)
    rig = here.rigs.create(drive="1:+Y", responses=dofs)
    test = here.measurements.start(beam.id, rig.id, route="expected").result()
    found = here.correlations.create(modes.id, beam.id, reduction="serep", measurement_id=test.id)
    again = here.correlations.get(found.id or "")
    for one in (found, again):
        assert one.cross_orthogonality is not None
        assert one.responses is not None
        np.testing.assert_allclose(one.cross_orthogonality, np.eye(4), atol=1e-9)  # rounding
        np.testing.assert_allclose(one.responses.frac, 1.0, rtol=1e-6)  # an ideal rig, a periodic signal
        assert one.responses.fdac.shape[1:] == (len(one.responses.freq),) * 2
    expanded = here.structures.expanded_modes(beam.id, modes.id)
    exact = here.structures.mode_shapes(beam.id, count=4)
    assert expanded.model.dofs == exact.dofs
    np.testing.assert_allclose(expanded.model.shapes, exact.shapes, atol=1e-6 * np.abs(exact.shapes).max())
    reduced = here.structures.reduced(beam.id, dofs, kind="irs", iterations=2)
    assert (np.abs(reduced.frequency_errors[:4]) < 1e-6).all()  # as Guyan's 0.2 % cubed
    assert [entry.kind for entry in here.catalog.reductions()] == ["dynamic", "guyan", "irs", "serep"]


def test_fits_charts_and_frfs_of_modes_come_back_to_be_drawn(here: ModalLab) -> None:
    damping = {"law": "structural", "stiffness_coefficient": 0.02}
    beam = here.structures.beam(length=1.5, n_elements=6, section=SECTION, material=STEEL, damping=damping)
    rig = here.rigs.create(drive="1:+Y", responses=["1:+Y", "3:+Y", "7:+Y"], noise={"response": 1e-3})
    test = here.measurements.start(beam.id, rig.id, route="drawn", seed=1).result(timeout=120)
    modes = here.modal_models.start(test.id, method="line_fit", n_modes=4, lines=12, leave_out=2).result()
    assert modes.choices["leave_out"] == "2: as requested"
    picture = here.modal_models.fit(modes.id, mode=2, response="7:+Y")
    assert (len(picture.freq), picture.used.sum()) == (12, 10)
    assert modes.fitted_frequencies is not None
    # the neighbours were still moving in the last round of the model: second order of the first guess
    assert picture.frequency == pytest.approx(modes.fitted_frequencies[1, 2], rel=1e-5)
    made = here.modal_models.frf(modes.id)
    np.testing.assert_array_equal(made.freq, test.freq)
    assert here.measurements.indicators(test.id).mif.shape == (1, 400)
    with pytest.raises(errors.NotFoundError, match="no stabilisation chart"):
        here.modal_models.chart(modes.id)
    left = here.modal_models.select(modes.id, drop=[1], merge=[[3, 4]])
    assert (len(left.modes), left.shapes.shape) == (2, (3, 2))
    assert left.frequencies[0] == modes.frequencies[1]
    with pytest.raises(errors.ClientError, match="no mode 5"):
        here.modal_models.select(modes.id, drop=[5])
    assert len(here.modal_models.get(left.id, details=["flags", "notes"]).modes) == 2
    with pytest.raises(errors.ClientError, match="no FRF at 5"):
        here.modal_models.fit(modes.id, mode=2, response="5:+Y")


def test_the_guide_to_time_records_makes_the_measured_frf(
    here: ModalLab, capsys: pytest.CaptureFixture[str]
) -> None:
    guide = (Path(__file__).parents[2] / "docs" / "rig.md").read_text()
    code = guide.split("## Time records")[1].split("```python")[1].split("```")[0]
    namespace = {"lab": here, "beam": here.structures.catalogue("chapter-5-beam")}
    exec(code, namespace)
    assert float(capsys.readouterr().out) < 1e-9  # rounding of two transforms
    records: Any = namespace["records"]
    assert records.time[-1] == pytest.approx(0.5 - 1 / records.sample_rate)  # of lines 2 Hz apart
    assert "100 of each run" in records._repr_html_()
    assert records.plot("7:+Y")[1].get_ylabel() == "acceleration, m/s²"
    with pytest.raises(ValueError, match="no run has the response 2"):
        records.of("2:+Y")
    assert here.measurements.wav(namespace["recorded"])[:4] == b"RIFF"  # type: ignore[arg-type]
