"""The tables. Change them only together with a new file in `migrations/versions`."""

import sqlalchemy as sa

METADATA = sa.MetaData(
    naming_convention={
        "ix": "ix_%(column_0_label)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
    }
)

THINGS = sa.Table(
    "things",
    METADATA,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("kind", sa.String(32), nullable=False),
    sa.Column("owner", sa.String(64), nullable=False),
    sa.Column("created", sa.String(40), nullable=False),
    sa.Column("version", sa.String(32), nullable=False),
    sa.Column("inputs", sa.JSON, nullable=False),
    sa.Column("seed", sa.BigInteger),
    sa.Column("body", sa.JSON, nullable=False),
    sa.Column("request", sa.JSON(none_as_null=True)),  # body of the request that described it, as it was sent
    sa.Column("arrays_hash", sa.String(64)),  # SHA-256 of the array file, null without arrays
    sa.Column("size", sa.BigInteger, nullable=False, server_default="0"),  # bytes of body and array file
    sa.Column("removed", sa.String(40)),  # when it was moved to the trash, null: it is there
    # What its owner says of it: beside `removed` the only columns that change.
    sa.Column("name", sa.String(100), nullable=False, server_default=""),
    sa.Column("labels", sa.JSON, nullable=False, server_default="[]"),
    sa.Column("comment", sa.Text, nullable=False, server_default=""),
    sa.Index("ix_things_shelf", "kind", "owner", "created", "id"),
    sa.Index("ix_things_size", "owner", "size"),
    sa.Index("ix_things_created", "kind", "created", "id"),
    sa.Index("ix_things_removed", "removed"),
)

# Which thing was made from which: what keeps an input from being removed.
LINKS = sa.Table(
    "links",
    METADATA,
    sa.Column("source", sa.ForeignKey("things.id", ondelete="CASCADE"), primary_key=True),
    sa.Column("target", sa.ForeignKey("things.id"), primary_key=True, index=True),
)

# Apart from the measurements, so that nothing which reads one comes across its truth.
TRUTHS = sa.Table(
    "truths",
    METADATA,
    sa.Column("measurement_id", sa.ForeignKey("things.id", ondelete="CASCADE"), primary_key=True),
    sa.Column("structure_id", sa.ForeignKey("things.id"), nullable=False, index=True),
    sa.Column("owner", sa.String(64), nullable=False),
    sa.Column("body", sa.JSON, nullable=False),
)

JOBS = sa.Table(
    "jobs",
    METADATA,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("owner", sa.String(64), nullable=False),
    sa.Column("task", sa.String(64), nullable=False),
    sa.Column("arguments", sa.JSON, nullable=False),
    sa.Column("created", sa.String(40), nullable=False),
    sa.Column("state", sa.String(16), nullable=False, index=True),
    sa.Column("fraction", sa.Float, nullable=False),
    sa.Column("message", sa.Text, nullable=False),
    sa.Column("result_id", sa.String(64), nullable=False),  # fixed at submission
    sa.Column("error", sa.JSON(none_as_null=True)),
    sa.Column("restarts", sa.Integer, nullable=False, server_default="0"),
    sa.Column("started", sa.String(40)),
    sa.Column("ended", sa.String(40)),
    sa.Column("due", sa.String(40)),  # when the end of a job is told whose work is done; null: no such job
    sa.Column("request_key", sa.String(128)),  # of the request that started it
    sa.Column("request_digest", sa.String(64)),
    sa.Column("lane", sa.String(16), nullable=False, server_default="long"),
    sa.Column("turn", sa.Integer, nullable=False, server_default="0"),  # its owner's, in the lane
    sa.Index("ix_jobs_turn", "lane", "owner", "turn"),
    sa.Index("ix_jobs_lane", "lane", "turn"),
    sa.Index("ix_jobs_task", "task", "state", "ended"),
    sa.Index("ix_jobs_request", "owner", "request_key", unique=True),
    sa.Index("ix_jobs_created", "owner", "created", "id"),
    sa.Index("ix_jobs_age", "created", "id"),
    sa.Index("ix_jobs_due", "due"),
)

# Processes that run jobs, each with a counter that rises while it lives.
EXECUTORS = sa.Table(
    "executors",
    METADATA,
    sa.Column("id", sa.String(128), primary_key=True),
    sa.Column("holder", sa.String(32), nullable=False),
    sa.Column("host", sa.String(256), nullable=False),
    sa.Column("pid", sa.Integer, nullable=False),
    sa.Column("beat", sa.BigInteger, nullable=False),
)

CLASSES = sa.Table(
    "classes",
    METADATA,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("name", sa.String(100), nullable=False),
    sa.Column("owner", sa.ForeignKey("keys.id"), nullable=False, index=True),
    sa.Column("created", sa.String(40), nullable=False),
    sa.Column("expires", sa.String(40)),  # when its members' keys do
    sa.Column("closed", sa.String(40)),
)

# Rows are revoked and never removed: results name their owners.
KEYS = sa.Table(
    "keys",
    METADATA,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("name", sa.String(100), nullable=False),
    sa.Column("role", sa.String(16), nullable=False),
    # Without a constraint: the two tables would have to be created before each other.
    sa.Column("class_id", sa.String(64), index=True),
    sa.Column("digest", sa.String(64), nullable=False),  # SHA-256 of the key
    sa.Column("created", sa.String(40), nullable=False),
    sa.Column("expires", sa.String(40)),
    sa.Column("revoked", sa.String(40)),
)

# What a class may read beside its members' own things.
SHARES = sa.Table(
    "shares",
    METADATA,
    sa.Column("class_id", sa.ForeignKey("classes.id"), primary_key=True),
    sa.Column("thing_id", sa.ForeignKey("things.id", ondelete="CASCADE"), primary_key=True, index=True),
)

SESSIONS = sa.Table(
    "sessions",
    METADATA,
    sa.Column("digest", sa.String(64), primary_key=True),  # SHA-256 of the cookie
    sa.Column("key_id", sa.ForeignKey("keys.id"), nullable=False, index=True),
    sa.Column("expires", sa.String(40), nullable=False),
)

# Removed with their use.
SIGN_IN_LINKS = sa.Table(
    "sign_in_links",
    METADATA,
    sa.Column("digest", sa.String(64), primary_key=True),  # SHA-256 of the secret in the link
    sa.Column("key_id", sa.ForeignKey("keys.id"), nullable=False, index=True),
    sa.Column("expires", sa.String(40), nullable=False),
)

# Closed and never removed: measurements of an assignment stay sealed.
ASSIGNMENTS = sa.Table(
    "assignments",
    METADATA,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("class_id", sa.ForeignKey("classes.id"), nullable=False, index=True),
    sa.Column("owner", sa.String(64), nullable=False),
    sa.Column("structure_id", sa.ForeignKey("things.id"), nullable=False, index=True),
    sa.Column("created", sa.String(40), nullable=False),
    sa.Column("closed", sa.String(40)),
    sa.Column("secret", sa.String(64), nullable=False),  # of all draws and seeds
    sa.Column("body", sa.JSON, nullable=False),
)

# Measurements of assignments. A student cannot remove one, and so upload it as if it came from elsewhere.
TRIALS = sa.Table(
    "trials",
    METADATA,
    sa.Column("assignment_id", sa.ForeignKey("assignments.id"), primary_key=True),
    sa.Column("student", sa.String(64), primary_key=True),
    sa.Column("number", sa.Integer, primary_key=True),
    sa.Column("request_key", sa.String(128)),
    sa.Column("measurement_id", sa.ForeignKey("things.id"), index=True, unique=True),  # null until it is made
)

SUBMISSIONS = sa.Table(
    "submissions",
    METADATA,
    sa.Column("assignment_id", sa.ForeignKey("assignments.id"), primary_key=True),
    sa.Column("student", sa.String(64), primary_key=True),
    sa.Column("number", sa.Integer, primary_key=True),
    sa.Column("created", sa.String(40), nullable=False),
    sa.Column("answer", sa.JSON, nullable=False),
    sa.Column("marks", sa.JSON, nullable=False),
)
