"""Keys, classes, what these share, sessions; indices for lists of all owners."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the tables and the indices."""
    op.create_index("ix_things_created", "things", ["kind", "created", "id"])
    op.create_index("ix_jobs_age", "jobs", ["created", "id"])
    op.create_table(
        "keys",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("name", sa.String(100), nullable=False),
        sa.Column("role", sa.String(16), nullable=False),
        sa.Column("class_id", sa.String(64)),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("created", sa.String(40), nullable=False),
        sa.Column("expires", sa.String(40)),
        sa.Column("revoked", sa.String(40)),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_keys")),
    )
    op.create_index(op.f("ix_keys_class_id"), "keys", ["class_id"])
    op.create_table(
        "classes",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("name", sa.String(100), nullable=False),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("created", sa.String(40), nullable=False),
        sa.Column("expires", sa.String(40)),
        sa.Column("closed", sa.String(40)),
        sa.ForeignKeyConstraint(["owner"], ["keys.id"], name=op.f("fk_classes_owner")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_classes")),
    )
    op.create_index(op.f("ix_classes_owner"), "classes", ["owner"])
    op.create_table(
        "shares",
        sa.Column("class_id", sa.String(64), nullable=False),
        sa.Column("thing_id", sa.String(64), nullable=False),
        sa.ForeignKeyConstraint(["class_id"], ["classes.id"], name=op.f("fk_shares_class_id")),
        sa.ForeignKeyConstraint(
            ["thing_id"], ["things.id"], name=op.f("fk_shares_thing_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("class_id", "thing_id", name=op.f("pk_shares")),
    )
    op.create_index(op.f("ix_shares_thing_id"), "shares", ["thing_id"])
    op.create_table(
        "sessions",
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("key_id", sa.String(64), nullable=False),
        sa.Column("expires", sa.String(40), nullable=False),
        sa.ForeignKeyConstraint(["key_id"], ["keys.id"], name=op.f("fk_sessions_key_id")),
        sa.PrimaryKeyConstraint("digest", name=op.f("pk_sessions")),
    )
    op.create_index(op.f("ix_sessions_key_id"), "sessions", ["key_id"])


def downgrade() -> None:
    """Drop them."""
    for table in ("sessions", "shares", "classes", "keys"):
        op.drop_table(table)
    op.drop_index("ix_jobs_age", "jobs")
    op.drop_index("ix_things_created", "things")
