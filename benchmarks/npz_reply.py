"""An FRF reply as npz against the same look-up answered with constant bytes of the same size."""

import tempfile
from functools import partial
from pathlib import Path

import anyio
import numpy as np
from fastapi import FastAPI
from starlette.responses import Response

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.api.app import create_app
from modallab.api.deps import IdPath, StoreDep
from modallab.api.runners import job_book
from modallab.api.settings import ServiceSettings
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.jobs.inline import InlineRunner
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

N_REQUESTS, ROUNDS = 50, 15
LIMIT = 1.5


def run(n_requests: int = N_REQUESTS, rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return (name, processor time over that of the constant reply, limit)."""
    with tempfile.TemporaryDirectory() as folder:
        settings = ServiceSettings(data=Path(folder))
        settings.store_place.prepare()
        app = create_app(settings, InlineRunner(job_book(settings), settings.store_place))
        stored = app.state.store.measurements.add(_measurement(), owner="local")
        constant = app.state.store.measurements.npz(stored)

        @app.get("/v1/constant/{id}")
        def answer(id: IdPath, store: StoreDep) -> Response:
            store.measurements.check(id)
            return Response(constant, media_type="application/octet-stream")

        ours, peer = f"/v1/measurements/{stored}/arrays", f"/v1/constant/{stored}"
        asked, constant_reply = (partial(anyio.run, _ask, app, path, n_requests) for path in (ours, peer))
        time_ratio = ratio(asked, constant_reply, rounds)
    return [("npz reply of 11 x 401 FRFs against constant bytes", time_ratio, LIMIT)]


def _measurement() -> Measurement:
    """Return a test of 11 responses and 401 lines."""
    rng = np.random.default_rng(0)
    responses = tuple(Dof(n, "Y") for n in range(1, 12))
    values = rng.standard_normal((401, 11, 1)) + 1j * rng.standard_normal((401, 11, 1))
    frf = FrfSet(np.linspace(0, 800, 401), values, responses, (Dof(1, "Y"),), FrfKind.INERTANCE)
    setup = RigSetup((Dof(1, "Y"),), responses)
    return Measurement(frf, rng.uniform(size=(401, 11)), 100.0, setup, np.abs(values))


async def _ask(app: FastAPI, path: str, n_requests: int) -> None:
    """Send the same request again and again, without a network between."""
    scope = {
        "type": "http",
        "method": "GET",
        "path": path,
        "headers": [(b"host", b"localhost")],
        "query_string": b"",
    }

    async def receive() -> dict[str, object]:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: object) -> None:
        if isinstance(message, dict) and message["type"] == "http.response.start":
            assert message["status"] == 200, message

    for _ in range(n_requests):
        await app(
            {**scope, "http_version": "1.1", "scheme": "http", "server": ("localhost", 80)}, receive, send
        )


BENCH = Bench(run, short=partial(run, n_requests=1, rounds=1))
