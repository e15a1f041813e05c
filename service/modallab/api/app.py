"""The application: routers, errors, limits, the store and the jobs."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from anyio import to_thread
from fastapi import APIRouter, Depends, FastAPI

import modallab
from modallab.api import about, catalog, document, jobs, problems
from modallab.api.body_limit import BodyLimit
from modallab.api.correlations import router as correlations
from modallab.api.diagnoses import router as diagnoses
from modallab.api.logs import RequestId
from modallab.api.measurements import router as measurements
from modallab.api.modal_models import router as modal_models
from modallab.api.operations import Operations, check_request
from modallab.api.page import router as page
from modallab.api.rigs import router as rigs
from modallab.api.settings import ServiceSettings
from modallab.api.structures import router as structures
from modallab.api.studies import router as studies
from modallab.api.updates import router as updates
from modallab.jobs.book import JobBook
from modallab.jobs.durable import DurableRunner
from modallab.jobs.runner import JobRunner
from modallab.store.place import engine_of, open_store


class Lab(FastAPI):
    """The application, with the OpenAPI document of `modallab.api.document`."""

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document, made once."""
        if self.openapi_schema is None:
            self.openapi_schema = document.build(self)
        return self.openapi_schema


def job_book(settings: ServiceSettings) -> JobBook:
    """Return the book of jobs that the settings name."""
    return JobBook(engine_of(settings.store_place), queue_length=settings.queue_length)


def durable_runner(settings: ServiceSettings) -> DurableRunner:
    """Return the runner that the settings name; with role `api` it only submits."""
    return DurableRunner(
        job_book(settings),
        settings.store_place,
        settings.job_place,
        executor_id=settings.executor_id,
        runs=settings.role == "all",
    )


def create_app(settings: ServiceSettings, runner: JobRunner | None = None) -> FastAPI:
    """Return the application, its database prepared by `modallab.api.cli` or `modallab init`.

    Parameters
    ----------
    runner
        What runs the jobs; by default the durable one.
    """
    chosen = durable_runner(settings) if runner is None else runner

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await to_thread.run_sync(app.openapi)  # no request waits for the document that it is checked with
        async with chosen:
            yield

    app = Lab(
        title="modallab",
        version=modallab.__version__,
        lifespan=lifespan,
        docs_url=None,  # FastAPI's loads from another host
        redoc_url=None,
        generate_unique_id_function=document.operation_id,
    )
    app.state.operations = Operations(app.openapi)
    app.state.settings, app.state.store, app.state.jobs = settings, open_store(settings.store_place), chosen
    v1 = APIRouter(prefix="/v1", dependencies=[Depends(check_request)])
    for part in (structures, rigs, measurements, modal_models, correlations, updates, studies, diagnoses):
        v1.include_router(part.router)
    for router in (jobs.router, catalog.router, about.router):
        v1.include_router(router)
    app.include_router(v1)
    app.include_router(page.router)
    problems.install(app)
    app.add_middleware(BodyLimit, json=settings.body_limit, upload=settings.upload_limit)
    app.add_middleware(RequestId)
    return app
