"""When a job ran, and by which request it was started."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

_COLUMNS = {"started": 40, "ended": 40, "request_key": 128, "request_digest": 64}


def upgrade() -> None:
    """Add the columns and their indices."""
    for name, length in _COLUMNS.items():
        op.add_column("jobs", sa.Column(name, sa.String(length)))
    op.create_index("ix_jobs_request", "jobs", ["owner", "request_key"], unique=True)
    op.create_index("ix_jobs_created", "jobs", ["owner", "created", "id"])


def downgrade() -> None:
    """Drop them."""
    op.drop_index("ix_jobs_created", "jobs")
    op.drop_index("ix_jobs_request", "jobs")
    for name in _COLUMNS:
        op.drop_column("jobs", name)
