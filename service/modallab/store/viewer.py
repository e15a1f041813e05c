"""Who asks for what is stored, and what of it exists for them: the one rule of ownership.

What is made belongs to the key that was sent. A student's key reads its own things, and what is shared with
its class; an instructor's also those of the students of its classes; an administrator's everything. What
was stored while the service had no keys belongs to `local`, for instructors and administrators to read and
remove.
"""

from dataclasses import dataclass
from enum import StrEnum

import sqlalchemy as sa

from modallab.store.tables import CLASSES, KEYS, SHARES, THINGS

LOCAL = "local"
UNPUBLISHED = "unpublished"
"""Owner of what its owner shall have later: no key has this id."""


class Visibility(StrEnum):
    """Whose things a viewer sees."""

    EVERYTHING = "everything"
    CLASSES = "classes"
    OWN = "own"


@dataclass(frozen=True)
class Viewer:
    """Somebody who asks."""

    owner: str
    """Owner of what the viewer makes: the id of a key, or `local`."""
    visibility: Visibility
    class_id: str | None = None
    """Class that the viewer is a member of; None: of none."""


EVERYONE = Viewer(LOCAL, Visibility.EVERYTHING)
"""Whoever asks a service without keys; and the service itself."""
NOBODY = Viewer("", Visibility.OWN)


def manageable(owner: sa.ColumnElement[str], viewer: Viewer) -> sa.ColumnElement[bool]:
    """Return the condition under which a row of this owner is the viewer's to read, use and remove."""
    if viewer.visibility is Visibility.EVERYTHING:
        return sa.true()
    if viewer.visibility is Visibility.OWN:
        return owner == viewer.owner
    teaches = KEYS.c.class_id.in_(sa.select(CLASSES.c.id).where(CLASSES.c.owner == viewer.owner))
    return sa.or_(owner.in_([viewer.owner, LOCAL]), owner.in_(sa.select(KEYS.c.id).where(teaches)))


def readable(viewer: Viewer) -> sa.ColumnElement[bool]:
    """Return the condition under which a stored thing exists for the viewer: nothing in the trash does."""
    is_there, condition = THINGS.c.removed.is_(None), manageable(THINGS.c.owner, viewer)
    if viewer.class_id is None:
        return is_there & condition
    shared_ids = sa.select(SHARES.c.thing_id).where(SHARES.c.class_id == viewer.class_id)
    return is_there & sa.or_(condition, THINGS.c.id.in_(shared_ids))
