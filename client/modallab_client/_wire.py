"""JSON and npz to results, and arguments to bodies; pure. Unknown fields of a reply are ignored."""

import io
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab_client import models
from modallab_client._generated.models import CatalogueEntry, JobStatus, StoredEntry
from modallab_client._read import read_as
from modallab_client.errors import BY_CODE, ClientError, JobFailedError, UnexpectedReplyError

Json = Mapping[str, Any]
Arrays = Mapping[str, NDArray[Any]]
T = TypeVar("T")


def body(**fields: Any) -> dict[str, Any]:
    """Return the fields that were given; None stands for the service's own default."""
    return {name: value for name, value in fields.items() if value is not None}


def plain(value: Any) -> Any:
    """Return JSON values of a body, which may hold parts of results."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def payload(content_type: str, content: bytes) -> Any:
    """Return a reply's JSON, None where it is empty, or its bytes where it is not JSON."""
    kind = content_type.partition(";")[0].strip().lower()
    if not content and kind != "application/octet-stream":
        return None
    if kind != "application/json" and not kind.endswith("+json"):
        return content
    try:
        return json.loads(content)
    except ValueError as error:
        raise UnexpectedReplyError("the reply says it is JSON, and is not") from error


def problem(status: int, content_type: str, content: bytes) -> ClientError:
    """Return the error that a refusing reply stands for."""
    try:
        document = payload(content_type, content)
    except UnexpectedReplyError:
        document = content
    if not isinstance(document, Mapping) or "code" not in document:
        # a proxy, or something that is no modallab service
        text = content[:300].decode(errors="replace").strip()
        return ClientError(text or f"the service answered {status}", code=f"http_{status}", status=status)
    code = str(document["code"])
    detail = str(document.get("detail") or document.get("title") or code)
    context = document.get("context")
    kind = BY_CODE.get(code, ClientError)
    return kind(detail, code=code, context=context if isinstance(context, Mapping) else None, status=status)


def job_failure(status: JobStatus) -> JobFailedError:
    """Return the error of a job that did not succeed, in the service's own words."""
    document = status.error or {}
    fallback = {"cancelled": "the job was cancelled"}.get(status.state, f"job {status.id} failed")
    return JobFailedError(
        str(document.get("detail") or document.get("title") or status.message or fallback),
        code=str(document.get("code") or ("cancelled" if status.state == "cancelled" else "job_failed")),
        context=document.get("context"),
        status=document.get("status"),
    )


def read(build: Callable[..., T], *parts: Any) -> T:
    """Return a result built from parts of a reply.

    Raises
    ------
    UnexpectedReplyError
        If a field is missing or of another shape than the contract says.
    """
    with _unreadable(build.__name__):
        return build(*parts)


def reply(kind: type[T], data: Json, **arrays: Any) -> T:
    """Return a reply as a generated type, with the fields that another request brought.

    Raises
    ------
    UnexpectedReplyError
        If a field is missing or of another type.
    """
    with _unreadable(kind.__name__):
        return read_as(kind, data, **arrays)


@contextmanager
def _unreadable(name: str) -> Iterator[None]:
    """Raise `UnexpectedReplyError` in place of the errors of a reply of another shape."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        what = f"{type(error).__name__}: {error}"
        raise UnexpectedReplyError(f"the service's reply could not be read as {name}, {what}") from error


def arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of an npz file, read-only.

    Raises
    ------
    UnexpectedReplyError
        If it is no npz file.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            return {name: _frozen(archive[name]) for name in archive.files}
    except (ValueError, OSError, EOFError) as error:
        raise UnexpectedReplyError("the reply is no npz file of plain arrays") from error


def npz(**values: ArrayLike | None) -> bytes:
    """Return an npz file of the arrays that were given."""
    file = io.BytesIO()
    arrays: dict[str, Any] = {name: np.asarray(value) for name, value in values.items() if value is not None}
    np.savez(file, **arrays)
    return file.getvalue()


def numbers(values: ArrayLike) -> list[float]:
    """Return real numbers as JSON has them."""
    return [float(value) for value in np.asarray(values, dtype=float)]


def pairs(values: ArrayLike) -> Any:
    """Return complex numbers as JSON has them, [re, im] innermost."""
    numbers = np.asarray(values, dtype=complex)
    return np.stack([numbers.real, numbers.imag], axis=-1).tolist()


def entry(data: Json) -> StoredEntry:
    """Return the entry of a stored thing."""
    return read_as(StoredEntry, data)


def event(text: str) -> dict[str, Any]:
    """Return the fields of one server-sent event."""
    return dict(json.loads(text))


def mode_shapes(given: Arrays) -> models.ModeShapes:
    """Return computed modes with their shapes."""
    return models.ModeShapes(given["frequencies"], given["shapes"], texts(given["dofs"]))


def frf(given: Arrays) -> models.Frf:
    """Return exact FRFs from their arrays."""
    return models.Frf(
        freq=given["freq"],
        values=given["values"],
        outputs=texts(given["outputs"]),
        inputs=texts(given["inputs"]),
        kind=str(given["kind"]),
        notes=texts(given["notes"]) if "notes" in given else (),
    )


def catalogue(members: Iterable[Json]) -> tuple[CatalogueEntry, ...]:
    """Return the members of a family of the catalogue."""
    return tuple(read_as(CatalogueEntry, member) for member in members)


def floats(values: Any) -> NDArray[np.float64]:
    """Return numbers as a read-only array; null, which JSON has for what is not finite, becomes NaN."""
    return _frozen(np.array(values, dtype=float))


def texts(values: Any) -> tuple[str, ...]:
    """Return names as a tuple."""
    return tuple(str(value) for value in values)


def number(value: float | None) -> float:
    """Return a number; null, which JSON has for what is not finite, becomes NaN."""
    return float("nan") if value is None else float(value)


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.flags.writeable = False
    return array
