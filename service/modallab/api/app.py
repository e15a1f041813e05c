"""The application: routers, errors, limits, the store and the jobs."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import APIRouter, Depends, FastAPI
from fastapi.responses import JSONResponse

import modallab
from modallab.api import about, catalog, classes, document, jobs, keys, limit_list, problems, sessions, trash
from modallab.api.access import OPERATORS, PERSONS
from modallab.api.assignments import router as assignments
from modallab.api.body_limit import BodyLimit
from modallab.api.correlations import router as correlations
from modallab.api.deps import ROOM
from modallab.api.diagnoses import router as diagnoses
from modallab.api.gate import Gate
from modallab.api.logs import RequestId
from modallab.api.measurements import router as measurements
from modallab.api.metrics import Measured, Metrics
from modallab.api.modal_models import router as modal_models
from modallab.api.offloading.processes import RequestProcesses
from modallab.api.operations import Operations, check_request
from modallab.api.page import router as page
from modallab.api.projects import router as projects
from modallab.api.rigs import router as rigs
from modallab.api.runners import durable_runner
from modallab.api.settings import ServiceSettings
from modallab.api.structures import router as structures
from modallab.api.studies import router as studies
from modallab.api.updates import router as updates
from modallab.jobs.runner import JobRunner
from modallab.store.assignments import AssignmentBook
from modallab.store.classes import ClassBook
from modallab.store.keys import KeyBook
from modallab.store.place import engine_of, open_store
from modallab.store.sessions import SessionBook
from modallab.store.sign_in_links import LinkBook


class Lab(FastAPI):
    """The application, with the OpenAPI document of `modallab.api.document`."""

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document, made once."""
        if self.openapi_schema is None:
            self.openapi_schema = document.build(self)
        return self.openapi_schema


def create_app(
    settings: ServiceSettings, runner: JobRunner | None = None, processes: RequestProcesses | None = None
) -> FastAPI:
    """Return the application, its database prepared by `modallab serve` or `modallab init`.

    Parameters
    ----------
    runner
        What runs the jobs; by default the durable one.
    processes
        What answers heavy requests; None: a thread of this process, as for all others.
    """
    chosen = durable_runner(settings) if runner is None else runner

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with chosen:
            yield
            if processes is not None:
                await processes.leave()

    app = Lab(
        title="modallab",
        version=modallab.__version__,
        lifespan=lifespan,
        openapi_url=None,  # FastAPI's makes all others wait for the document
        docs_url=None,  # FastAPI's loads from another host
        redoc_url=None,
        generate_unique_id_function=document.operation_id,
    )
    app.state.processes = processes
    app.state.operations = Operations(app.routes, app.openapi)
    app.state.settings, app.state.store, app.state.jobs = settings, open_store(settings.store_place), chosen
    app.state.keys = KeyBook(engine_of(settings.store_place))
    app.state.classes = ClassBook(engine_of(settings.store_place), app.state.keys)
    app.state.assignments = AssignmentBook(engine_of(settings.store_place))
    app.state.sessions = SessionBook(engine_of(settings.store_place))
    app.state.links = LinkBook(engine_of(settings.store_place))
    app.include_router(_routes())
    app.include_router(page.router)
    problems.install(app)
    app.add_middleware(
        Gate,
        engine=engine_of(settings.store_place),
        allowed_hosts=settings.host_names,
        embedding_key=settings.embedding_key,
    )
    app.add_middleware(BodyLimit, json=settings.body_limit, upload=settings.upload_limit)
    metrics = Metrics(settings.store_place)
    app.add_middleware(Measured, metrics=metrics)
    app.add_api_route("/openapi.json", app.openapi, include_in_schema=False, response_class=JSONResponse)
    app.add_api_route("/metrics", metrics.reply, include_in_schema=False, dependencies=[OPERATORS])
    app.add_middleware(RequestId)
    return app


def _routes() -> APIRouter:
    v1 = APIRouter(prefix="/v1", dependencies=[Depends(check_request)])
    for part in (structures, rigs, measurements, modal_models, correlations, updates, studies, diagnoses):
        v1.include_router(part.router, dependencies=[PERSONS, ROOM])
    for storing in (assignments.router, projects.router):
        v1.include_router(storing, dependencies=[PERSONS, ROOM])
    for router in (jobs.router, catalog.router, trash.router):
        v1.include_router(router, dependencies=[PERSONS])
    for router in (keys.router, classes.router, sessions.router, about.router, limit_list.router):
        v1.include_router(router)
    return v1
