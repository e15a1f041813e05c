"""Dependencies of request handlers."""

from hashlib import sha256
from typing import Annotated, Any

from anyio import to_thread
from fastapi import Depends, Header, Path, Query, Request
from pydantic import StringConstraints

from modallab.api.access import CallerDep
from modallab.api.settings import ServiceSettings
from modallab.api.wire import ID_PATTERN
from modallab.jobs.runner import JobRunner, RequestKey
from modallab.store.arrays import FolderArrays
from modallab.store.base import Store
from modallab.store.place import engine_of
from modallab.store.quotas import check_storage
from modallab.store.viewer import Viewer

IdempotencyKey = Annotated[
    str | None,
    Header(
        pattern=r"^[!-~]{1,128}$",
        description="name of the request: with the same name and body again, the same job is returned",
    ),
]

# `async`, although they wait for nothing: plain functions would each take a thread.


async def _store(request: Request, caller: CallerDep) -> Store:
    store: Store = request.app.state.store
    return store.as_seen_by(caller.viewer)


async def _jobs(request: Request) -> JobRunner:
    jobs: JobRunner = request.app.state.jobs
    return jobs


async def _request_key(request: Request, idempotency_key: IdempotencyKey = None) -> RequestKey | None:
    if idempotency_key is None:
        return None
    digest = sha256(f"{request.method} {request.url.path}\n".encode() + await request.body())
    return RequestKey(idempotency_key, digest.hexdigest())


async def _settings(request: Request) -> ServiceSettings:
    settings: ServiceSettings = request.app.state.settings
    return settings


async def _viewer(caller: CallerDep) -> Viewer:
    return caller.viewer


async def _owner(caller: CallerDep) -> str:
    return caller.viewer.owner


async def _room(
    request: Request, caller: CallerDep, settings: Annotated[ServiceSettings, Depends(_settings)]
) -> None:
    """Refuse what would be stored where too much is stored already; every POST of a resource stores."""
    if request.method == "POST":
        place, owner = settings.store_place, caller.viewer.owner
        files = FolderArrays(place.folder)
        await to_thread.run_sync(check_storage, engine_of(place), files, owner, settings.storage_quotas)


ROOM: Any = Depends(_room)
StoreDep = Annotated[Store, Depends(_store)]
JobsDep = Annotated[JobRunner, Depends(_jobs)]
SettingsDep = Annotated[ServiceSettings, Depends(_settings)]
RequestKeyDep = Annotated[RequestKey | None, Depends(_request_key)]
OwnerDep = Annotated[str, Depends(_owner)]
ViewerDep = Annotated[Viewer, Depends(_viewer)]

Id = Annotated[str, StringConstraints(pattern=ID_PATTERN)]
IdPath = Annotated[str, Path(pattern=ID_PATTERN, description="id of the stored object")]
Limit = Annotated[int, Query(ge=1, le=500, description="how many entries at most")]
After = Annotated[Id | None, Query(description="id of the last entry of the page before")]
OwnerWanted = Annotated[
    Id | None,
    Query(
        alias="owner",
        description="id of the owner's key; left out: all entries that the caller may see, or the caller's "
        "own jobs",
    ),
]
