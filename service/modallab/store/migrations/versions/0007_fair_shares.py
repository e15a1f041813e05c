"""Turns of owners in the queue of jobs, its two lanes, and sizes of what is stored."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns; what waits already comes first, and array files stored so far do not count."""
    op.add_column("jobs", sa.Column("lane", sa.String(16), nullable=False, server_default="long"))
    op.add_column("jobs", sa.Column("turn", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("things", sa.Column("size", sa.BigInteger(), nullable=False, server_default="0"))
    things = sa.table("things", sa.column("size"), sa.column("body", sa.JSON()))
    op.execute(things.update().values(size=sa.func.length(sa.cast(things.c.body, sa.Text))))
    op.create_index("ix_things_size", "things", ["owner", "size"])
    op.create_index("ix_jobs_turn", "jobs", ["lane", "owner", "turn"])
    op.create_index("ix_jobs_lane", "jobs", ["lane", "turn"])
    op.create_index("ix_jobs_task", "jobs", ["task", "state", "ended"])


def downgrade() -> None:
    """Drop them."""
    op.drop_index("ix_things_size", "things")
    op.drop_column("things", "size")
    for index in ("ix_jobs_task", "ix_jobs_lane", "ix_jobs_turn"):
        op.drop_index(index, "jobs")
    for name in ("turn", "lane"):
        op.drop_column("jobs", name)
