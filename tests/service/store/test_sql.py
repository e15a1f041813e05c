"""What is stored comes back the same, once, whole, and not while it is in use."""

import threading
from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, ModalLabError, NotFoundError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel, Mode, Spread
from modallab.core.place import Channels, EffectSpec, Members
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.hardware import Accelerometers
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.store.arrays import FolderArrays
from modallab.store.base import InUseError, MissingFileError, Truth
from modallab.store.place import StorePlace
from modallab.store.sql import SqlStore

BEAM = STRUCTURES["chapter-5-beam"]()
RESPONSES = tuple(Dof(n, "Y") for n in (1, 3, 5))
RIG = RigSetup(
    drives=(Dof(1, "Y", -1),),
    responses=RESPONSES,
    accelerometers=Accelerometers(mass=0.02, roving=True),
    effects=(EffectSpec("leakage"), EffectSpec("extra_mass", Dof(5, "Y"), {"mass": 0.1})),
)


def measurement() -> Measurement:
    rng = np.random.default_rng(0)
    shape = (7, 3, 1)
    values = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    return Measurement(
        frf=FrfSet(np.linspace(0, 60, 7), values, RESPONSES, (RIG.drive,), FrfKind.INERTANCE),
        coherence=rng.uniform(size=(7, 3)),
        averages=94.8,
        setup=RIG,
        force_spectrum=rng.uniform(size=shape),
        seed=5,
        notes=("a note",),
    )


def test_a_structure_comes_back_as_it_was(store: SqlStore) -> None:
    found = store.structures.get(store.structures.add(BEAM, owner="me"))
    assert (found.nodes, found.members, found.damping) == (BEAM.nodes, BEAM.members, BEAM.damping)
    assert (found.dofs, found.supports, found.name) == (BEAM.dofs, BEAM.supports, BEAM.name)


def test_a_rig_comes_back_as_it_was(store: SqlStore) -> None:
    assert store.rigs.get(store.rigs.add(RIG, owner="me")) == RIG


def test_a_measurement_comes_back_to_the_last_bit(store: SqlStore) -> None:
    given = measurement()
    found = store.measurements.get(store.measurements.add(given, owner="me"))
    np.testing.assert_array_equal(found.frf.values, given.frf.values)
    np.testing.assert_array_equal(found.coherence, given.coherence)
    np.testing.assert_array_equal(found.force_spectrum, given.force_spectrum)
    assert found.response_spectrum is None
    assert (found.frf.outputs, found.frf.inputs, found.frf.kind) == (
        RESPONSES,
        (RIG.drive,),
        FrfKind.INERTANCE,
    )
    assert (found.averages, found.setup, found.seed, found.notes) == (94.8, RIG, 5, ("a note",))


def test_a_modal_model_comes_back_with_what_its_fits_did_not_show(store: SqlStore) -> None:
    spread = Spread(23.0, 24.0, 23.5, 0.1, 3)
    modes = (
        Mode(23.5, 0.01, np.array([1.0, 0.5j, -1.0]), frequency_spread=spread, flags=("outlier 3:+Y",)),
        Mode(65.0, 0.005, np.array([1.0, -0.5, 1.0]), standard_errors={"frequency": 0.01}),
    )
    fitted = np.array([[23.4, np.nan, 23.6], [65.0, 65.1, np.nan]])
    given = ModalModel(modes, RESPONSES, method="dobson", fitted_frequency=fitted, notes=("few lines",))
    found = store.modal_models.get(store.modal_models.add(given, owner="me"))
    np.testing.assert_array_equal(found.shapes, given.shapes)
    np.testing.assert_array_equal(found.fitted_frequency, fitted)
    assert found.modes[0].frequency_spread == spread
    assert found.modes[0].flags == ("outlier 3:+Y",)
    assert found.modes[1].standard_errors == {"frequency": 0.01}
    assert (found.dofs, found.method, found.notes) == (RESPONSES, "dobson", ("few lines",))


def test_an_entry_says_how_to_make_the_thing_again(store: SqlStore) -> None:
    rig = store.rigs.add(RIG, owner="me")
    entry = store.measurements.entry(
        store.measurements.add(measurement(), owner="me", inputs={"rig_id": rig}, seed=2**63 - 1)
    )
    assert (entry.inputs, entry.seed, entry.owner, entry.kind) == (
        {"rig_id": rig},
        2**63 - 1,
        "me",
        "measurement",
    )


def test_work_done_twice_is_stored_once(store: SqlStore) -> None:
    first = store.structures.add(BEAM, owner="me", id="chosen")
    again = store.structures.add(BEAM, owner="me", id="chosen")
    assert first == again == "chosen"
    assert len(store.structures.list(owner="me", limit=10)) == 1


def test_two_who_store_under_one_id_at_the_same_time_store_once(store: SqlStore) -> None:
    ready = threading.Barrier(4)

    def add() -> None:
        ready.wait()
        store.measurements.add(measurement(), owner="me", id="chosen")

    threads = [threading.Thread(target=add) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(store.measurements.list(owner="me", limit=10)) == 1
    assert store.measurements.get("chosen").averages == 94.8


def test_what_another_thing_was_made_from_cannot_be_removed(store: SqlStore) -> None:
    base = store.structures.add(BEAM, owner="me")
    changed = store.structures.add(BEAM, owner="me", inputs={"structure_id": base})
    with pytest.raises(InUseError):
        store.structures.remove(base)
    store.structures.remove(changed)
    store.structures.remove(base)
    assert not store.structures.holds(base)


@pytest.mark.parametrize(
    ("read", "error"),
    [
        (lambda store, id: store.measurements.get(id), NotFoundError),
        (lambda store, id: store.measurements.npz(id), NotFoundError),
        (lambda store, id: store.projects.parts(id), InvalidInputError),
    ],
)
def test_what_is_removed_while_it_is_read_is_told_as_removed(
    store: SqlStore,
    monkeypatch: pytest.MonkeyPatch,
    read: Callable[[SqlStore, str], object],
    error: type[ModalLabError],
) -> None:
    id = store.measurements.add(measurement(), owner="me")
    files, reading = FolderArrays.get, threading.Event()

    def removed_meanwhile(self: FolderArrays, id: str, digest: str) -> bytes:
        if not reading.is_set():
            reading.set()
            store.measurements.remove(id)
        return files(self, id, digest)

    monkeypatch.setattr(FolderArrays, "get", removed_meanwhile)
    with pytest.raises(error):
        read(store, id)
    assert reading.is_set()


def test_a_lost_array_file_is_told_as_lost(place: StorePlace, store: SqlStore) -> None:
    id = store.measurements.add(measurement(), owner="me")
    for path in place.folder.rglob("*.npz"):
        path.unlink()
    with pytest.raises(MissingFileError):
        store.measurements.get(id)


def test_nothing_is_made_from_what_is_not_there(store: SqlStore) -> None:
    with pytest.raises(NotFoundError):
        store.structures.add(BEAM, owner="me", inputs={"structure_id": "gone"}, id="orphan")
    assert not store.structures.holds("orphan")


def test_an_id_of_one_kind_is_unknown_to_another(store: SqlStore) -> None:
    rig = store.rigs.add(RIG, owner="me")
    with pytest.raises(NotFoundError, match="no structure"):
        store.structures.get(rig)


def test_lists_show_an_owner_his_own_newest_first_page_by_page(store: SqlStore) -> None:
    ids = [store.rigs.add(RIG, owner="me") for _ in range(5)]
    store.rigs.add(RIG, owner="you")
    first = [entry.id for entry in store.rigs.list(owner="me", limit=3)]
    second = [entry.id for entry in store.rigs.list(owner="me", limit=3, cursor=first[-1])]
    assert first + second == ids[::-1]


def test_what_is_added_together_is_seen_together_or_never(store: SqlStore) -> None:
    def killed_half_way() -> None:
        with store.together() as batch:
            batch.structures.add(BEAM, owner="me", id="half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        killed_half_way()
    assert not store.structures.holds("half")
    with store.together() as batch:
        batch.structures.add(BEAM, owner="me", id="base")
        batch.structures.add(BEAM, owner="me", id="changed", inputs={"structure_id": "base"})
    assert store.structures.entry("changed").inputs == {"structure_id": "base"}


def test_a_truth_is_for_its_owner_and_keeps_its_structure(store: SqlStore) -> None:
    hidden = store.structures.add(BEAM, owner="me")
    test = store.measurements.add(measurement(), owner="me")
    effects = (
        EffectSpec("density_error", Members((1, 2)), {"factor": 2.0}),
        EffectSpec("gain_error", Channels(RESPONSES[:1]), {"factor": 1.1}),
    )
    store.truths.add(Truth(hidden, effects), measurement_id=test, owner="me")
    assert store.truths.get(test, owner="me") == Truth(hidden, effects)
    with pytest.raises(NotFoundError):
        store.truths.get(test, owner="you")
    with pytest.raises(InUseError):
        store.structures.remove(hidden)
    store.measurements.remove(test)  # its truth goes with it
    store.structures.remove(hidden)


def test_nothing_a_measurement_is_read_with_holds_its_truth(store: SqlStore) -> None:
    hidden = store.structures.add(BEAM, owner="me")
    test = store.measurements.add(measurement(), owner="me")
    store.truths.add(Truth(hidden, (EffectSpec("drift"),)), measurement_id=test, owner="me")
    read = repr(store.measurements.get(test)) + repr(store.measurements.entry(test))
    stored = store.measurements.npz(test)
    for word in (hidden, "drift"):
        assert word not in read
        assert word.encode() not in stored
