"""Classes: keys for the students of a list, and what is shared with them."""

import csv
import io
from collections.abc import Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request, status
from fastapi.exceptions import RequestValidationError
from pydantic import AwareDatetime, Field, ValidationError

from modallab.api.access import TeacherKeyDep
from modallab.api.deps import Id, IdPath
from modallab.api.examples import example
from modallab.api.files import CsvRoute
from modallab.api.keys import SECRET, KeyReply, KeysDep, NewKeyReply, keep_secret, key_reply, new_key_reply
from modallab.api.media import CsvWanted, csv_replies, csv_reply
from modallab.api.replies import reply
from modallab.api.wire import ID_PATTERN, HolderName, Reply, Wire
from modallab.core.errors import InvalidInputError
from modallab.store.classes import Class, ClassBook
from modallab.store.keys import NewKey

router = APIRouter(prefix="/classes", tags=["keys"])

_CLASS = {"name": "Structural dynamics, autumn", "expires": "2030-03-31T00:00:00Z"}
_MEMBERS = {"names": ["student 1", "student 2"]}
_COLUMNS = ("name", "id", "key")
_MOST_MEMBERS = 1000
_CSV_REPLY: dict[int | str, dict[str, Any]] = {201: csv_replies(_COLUMNS)[200]}


class ClassIn(Wire):
    """A class to be made."""

    name: HolderName
    """name of the class"""
    expires: AwareDatetime | None = None
    """when the keys of its members expire; null: never"""


class MembersIn(Wire):
    """Students who join a class."""

    names: list[HolderName] = Field(
        min_length=1, max_length=_MOST_MEMBERS, json_schema_extra={"uniqueItems": True}
    )
    """names of the students, each once"""


class ShareIn(Wire):
    """Something stored that a class may read."""

    resource_id: Id
    """id of a structure, rig, measurement or result"""


ClassReply: Any = reply(Class, "Class")


RollReply: Any = reply(
    Class,
    "Roll",
    members=(list[KeyReply], "Keys of the members, newest first."),
    shares=(list[str], "Ids of what is shared with the class."),
)


class Classes(Reply):
    """All classes."""

    items: list[ClassReply]
    """Classes, newest first."""


class NewMembers(Reply):
    """Keys of new members."""

    members: list[NewKeyReply]
    """Keys in the order of the names."""


async def _classes(request: Request) -> ClassBook:
    classes: ClassBook = request.app.state.classes
    return classes


async def _listed(request: Request) -> MembersIn:
    """Return the students of a table, its column `name`."""
    names = _names(await request.body())
    try:
        return MembersIn.model_validate({"names": names})
    except ValidationError as error:
        faults = [fault | {"loc": ("body", *fault["loc"])} for fault in error.errors()]
        raise RequestValidationError(faults, body={"names": names}) from None


def _names(table: bytes) -> list[str]:
    try:
        rows = csv.DictReader(io.StringIO(table.decode("utf-8-sig")))
        titles = list(rows.fieldnames or ())
        names = [(row.get("name") or "").strip() for row in rows]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InvalidInputError(
            f"the table cannot be read: {error}", field="body", allowed="CSV in UTF-8"
        ) from None
    if "name" not in titles:
        raise InvalidInputError(
            "the table has no column `name`",
            field="body",
            value=", ".join(titles),
            allowed="a first line of titles, `name` among them",
        )
    return [name for name in names if name]


ClassesDep = Annotated[ClassBook, Depends(_classes)]
ListedDep = Annotated[MembersIn, Depends(_listed)]
ResourceId = Annotated[str, Path(pattern=ID_PATTERN, description="id of what is shared")]


@router.post("", status_code=status.HTTP_201_CREATED, response_model=ClassReply, summary="Create a class")
def create_class(body: Annotated[ClassIn, example(_CLASS)], classes: ClassesDep, key: TeacherKeyDep) -> Any:
    """Return a new class without members. Only for instructors and administrators."""
    return ClassReply.model_validate(classes.create(body.name, owner=key.id, expires=body.expires))


@router.get("", response_model=Classes, summary="List classes")
def list_classes(classes: ClassesDep, key: TeacherKeyDep) -> Any:
    """Return the caller's classes, or all classes to an administrator."""
    return Classes(items=[ClassReply.model_validate(c) for c in classes.list(viewer=key.viewer)])


@router.get("/{id}", response_model=RollReply, summary="Get a class")
def get_class(id: IdPath, classes: ClassesDep, keys: KeysDep, key: TeacherKeyDep) -> Any:
    """Return a class with its members, and what is shared with it."""
    entered = classes.get(id, viewer=key.viewer)
    members = keys.list(viewer=key.viewer, class_id=id)
    return RollReply.model_validate(
        vars(entered) | {"members": [key_reply(k) for k in members], "shares": classes.shares(id)}
    )


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, summary="Close a class")
def close_class(id: IdPath, classes: ClassesDep, key: TeacherKeyDep) -> None:
    """Revoke all keys of a class at once; what its members made stays, visible to its instructor."""
    classes.close(id, viewer=key.viewer)


def add_listed_members(
    id: IdPath, key: TeacherKeyDep, listed: ListedDep, classes: ClassesDep, as_csv: CsvWanted
) -> Any:
    """Return keys of new members from a table."""
    return _new_members(classes.add_members(id, listed.names, viewer=key.viewer), as_csv=as_csv)


# Out of the document, where a path has one POST: the route below tells of both.
router.add_api_route(
    "/{id}/members",
    add_listed_members,
    methods=["POST"],
    status_code=status.HTTP_201_CREATED,
    include_in_schema=False,
    dependencies=[SECRET],
    route_class_override=CsvRoute,
)


@router.post(
    "/{id}/members",
    status_code=status.HTTP_201_CREATED,
    response_model=NewMembers,
    responses=_CSV_REPLY,
    summary="Add members",
    dependencies=[SECRET],
)
def add_members(
    id: IdPath,
    body: Annotated[MembersIn, example(_MEMBERS)],
    classes: ClassesDep,
    as_csv: CsvWanted,
    key: TeacherKeyDep,
) -> Any:
    """Return a student's key for each name, told once: JSON or CSV, in and out."""
    return _new_members(classes.add_members(id, body.names, viewer=key.viewer), as_csv=as_csv)


def _new_members(members: Sequence[NewKey], *, as_csv: bool) -> Any:
    if not as_csv:
        return NewMembers(members=[new_key_reply(new) for new in members])
    rows = ({"name": new.key.name, "id": new.key.id, "key": new.text} for new in members)
    table = csv_reply(_COLUMNS, rows)
    table.status_code = status.HTTP_201_CREATED
    keep_secret(table)
    return table


@router.post(
    "/{id}/shares",
    status_code=status.HTTP_201_CREATED,
    response_model=RollReply,
    summary="Share with a class",
)
def share_with_class(
    id: IdPath,
    body: Annotated[ShareIn, example({"resource_id": "5f0c31"})],
    classes: ClassesDep,
    keys: KeysDep,
    key: TeacherKeyDep,
) -> Any:
    """Return a class whose members may read and use something stored; they cannot remove it."""
    classes.share(id, body.resource_id, viewer=key.viewer)
    return get_class(id, classes, keys, key)


@router.delete(
    "/{id}/shares/{resource_id}", status_code=status.HTTP_204_NO_CONTENT, summary="End sharing with a class"
)
def withdraw_from_class(id: IdPath, resource_id: ResourceId, classes: ClassesDep, key: TeacherKeyDep) -> None:
    """End the sharing of something stored; what members made of it stays theirs."""
    classes.withdraw(id, resource_id, viewer=key.viewer)
