"""A measurement and an extraction with the generated Python client: argument 1 its folder, 2 the address."""

import io
import sys
import time
from typing import Any

sys.path.insert(0, sys.argv[1])

from lab_client import Client  # type: ignore[import-not-found]
from lab_client.api.jobs import get_job  # type: ignore[import-not-found]
from lab_client.api.measurements import (  # type: ignore[import-not-found]
    get_measurement_arrays,
    start_measurement,
)
from lab_client.api.modal_models import get_modal_model, start_modal_model  # type: ignore[import-not-found]
from lab_client.api.rigs import create_rig, get_rig  # type: ignore[import-not-found]
from lab_client.api.structures import create_structure  # type: ignore[import-not-found]
from lab_client.models import (  # type: ignore[import-not-found]
    CatalogueIn,
    MeasurementStart,
    ModalModelStart,
    Problem,
    RigIn,
)

client = Client(sys.argv[2])


def result_of(job: Any) -> str:
    """Return the id of what a job made."""
    while job.state in ("queued", "running"):
        time.sleep(0.1)
        job = get_job.sync(job.id, client=client)
    assert job.state == "succeeded", job
    return str(job.result_id)


body = CatalogueIn.from_dict({"kind": "catalogue", "name": "chapter-5-beam"})
beam = create_structure.sync(client=client, body=body)
rig = create_rig.sync(
    client=client, body=RigIn.from_dict({"drive": "1:+Y", "responses": ["1:+Y", "7:+Y", "21:+Y"]})
)
start = MeasurementStart.from_dict({"structure_id": beam.id, "rig_id": rig.id, "route": "expected"})
test = result_of(start_measurement.sync(client=client, body=start))
arrays = get_measurement_arrays.sync(test, client=client)
assert isinstance(arrays.payload, io.BytesIO), arrays
assert arrays.payload.read(2) == b"PK"  # npz is a zip file
extraction = ModalModelStart.from_dict({"measurement_id": test, "method": "dobson", "n_modes": 5})
modes = get_modal_model.sync(result_of(start_modal_model.sync(client=client, body=extraction)), client=client)
refused = get_rig.sync("none", client=client)
assert isinstance(refused, Problem), refused
sys.stdout.write(f"{len(modes.modes)} {refused.code}\n")
