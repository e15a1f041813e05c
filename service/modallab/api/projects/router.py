"""Projects: all things of an owner as one file."""

import os
import tempfile
from collections import Counter
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, File, UploadFile, status
from starlette.background import BackgroundTask
from starlette.responses import FileResponse, Response

from modallab.api.deps import OwnerDep, SettingsDep, StoreDep
from modallab.api.files import ZIP, ZIP_TYPE
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.projects.archive import opened, renamed, write_project
from modallab.api.projects.checks import check, thing_of
from modallab.api.projects.schemas import ImportedProject
from modallab.api.shelves import LabelWanted
from modallab.store.base import Description

router = APIRouter(prefix="/projects", tags=["projects"], route_class=OffloadedRoute)
SHELVES = {
    "structure": "structures",
    "rig": "rigs",
    "measurement": "measurements",
    "modal_model": "modal_models",
    "correlation": "correlations",
    "update": "updates",
    "study": "studies",
    "diagnosis": "diagnoses",
}


@router.get("/export", response_class=Response, responses=ZIP, summary="Export a project")
def export_project(
    store: StoreDep, owner: OwnerDep, settings: SettingsDep, label: LabelWanted = None
) -> Response:
    """Return what the caller has stored as one file, with arrays, names, labels and comments.

    With a label: what has it, and what that was made from. Left out, and listed in the file: measurements of
    assignments, and what was made from these or from what others have. No truth is written.
    """
    handle, name = tempfile.mkstemp(prefix="modallab-", suffix=".zip")
    path = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            project = store.projects.contents(owner=owner, label=label)
            write_project(store, project, file, largest=settings.upload_limit)
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    return FileResponse(
        path, media_type=ZIP_TYPE, filename="project.zip", background=BackgroundTask(path.unlink)
    )


@router.post(
    "/import",
    status_code=status.HTTP_201_CREATED,
    response_model=ImportedProject,
    summary="Import a project",
)
def import_project(
    file: Annotated[UploadFile, File(description="a file of `GET /v1/projects/export`")],
    store: StoreDep,
    settings: SettingsDep,
    owner: OwnerDep,
) -> Any:
    """Store the content of a project file, whole or not at all.

    Everything gets a new id and belongs to the caller; what was made from what is as in the file.
    """
    ids: dict[str, str] = {}
    with opened(file.file, largest=settings.upload_limit) as project:
        # All are checked before the database is locked: SQLite has one writer at a time.
        for read in project.contents.things:
            check(project, read)
        with store.together() as batch:
            for read in project.contents.things:
                thing, request = thing_of(project, read)
                shelf = getattr(batch, SHELVES[read.kind])
                inputs = renamed(read.inputs, ids)
                ids[read.id] = shelf.add(
                    thing, owner=owner, inputs=inputs, seed=read.seed, request=request, version=read.version
                )
                shelf.describe(ids[read.id], Description(read.name, read.labels, read.comment))
    return ImportedProject(ids=ids, counts=Counter(read.kind for read in project.contents.things))
