"""Classes and keys: who may do what on a service."""

from collections.abc import Sequence

from modallab_client import _wire
from modallab_client._generated import models
from modallab_client._sync.pages import all_items
from modallab_client._sync.transport import Transport
from modallab_client.results import Class, Key, Link, NewKey, Roll
from modallab_client.stored import Identified, id_of


class Classes:
    """Classes on the service; for instructors."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def create(self, name: str, *, expires: str | None = None) -> Class:
        """Return a new class without members.

        Parameters
        ----------
        expires
            When the keys of its members expire, ISO 8601; None: never.
        """
        body = _wire.body(name=name, expires=expires)
        return _wire.reply(Class, self._transport.request("POST", "/v1/classes", json=body))

    def list(self) -> tuple[Class, ...]:
        """Return one's classes, newest first."""
        return _wire.reply(models.Classes, self._transport.request("GET", "/v1/classes")).items

    def get(self, class_id: Identified) -> Roll:
        """Return a class with its members, and the ids of what is shared with it."""
        return _wire.reply(Roll, self._transport.request("GET", f"/v1/classes/{id_of(class_id)}"))

    def close(self, class_id: Identified) -> None:
        """Revoke all keys of a class."""
        self._transport.request("DELETE", f"/v1/classes/{id_of(class_id)}")

    def add_members(self, class_id: Identified, names: Sequence[str]) -> tuple[NewKey, ...]:
        """Return a new student's key for each name, told this once."""
        path = f"/v1/classes/{id_of(class_id)}/members"
        reply = self._transport.request("POST", path, json={"names": list(names)})
        return _wire.reply(models.NewMembers, reply).members

    def share(self, class_id: Identified, resource_id: Identified) -> Roll:
        """Return a class whose members may read and use something stored."""
        path = f"/v1/classes/{id_of(class_id)}/shares"
        reply = self._transport.request("POST", path, json={"resource_id": id_of(resource_id)})
        return _wire.reply(Roll, reply)

    def withdraw(self, class_id: Identified, resource_id: Identified) -> None:
        """End the sharing of something stored."""
        path = f"/v1/classes/{id_of(class_id)}/shares/{id_of(resource_id)}"
        self._transport.request("DELETE", path)


class Keys:
    """Keys on the service."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def create(self, name: str, role: str, *, expires: str | None = None) -> NewKey:
        """Return a new key, told this once; for administrators.

        Parameters
        ----------
        name, role
            Holder, and `admin`, `instructor`, `student` or `service`.
        expires
            First time at which it does not count, ISO 8601; None: never.
        """
        body = _wire.body(name=name, role=role, expires=expires)
        return _wire.reply(NewKey, self._transport.request("POST", "/v1/keys", json=body))

    def list(self) -> tuple[Key, ...]:
        """Return one's own key, with the keys of one's classes, or all keys, newest first."""
        return all_items(self._transport, "/v1/keys", models.KeyPage)

    def get(self, key_id: str) -> Key:
        """Return what is known of a key: everything but the key itself."""
        return _wire.reply(Key, self._transport.request("GET", f"/v1/keys/{key_id}"))

    def rotate(self, key_id: str) -> NewKey:
        """Return a key with a new text; the former text counts no more."""
        return _wire.reply(NewKey, self._transport.request("POST", f"/v1/keys/{key_id}/rotate"))

    def link(self, key_id: Identified) -> Link:
        """Return a link to the page, told this once, that signs the holder of a key in once."""
        path = f"/v1/keys/{id_of(key_id)}/links"
        return _wire.reply(Link, self._transport.request("POST", path))

    def revoke(self, key_id: str) -> None:
        """Revoke a key at once and for good."""
        self._transport.request("DELETE", f"/v1/keys/{key_id}")
