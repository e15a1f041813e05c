"""When the end of a job is told whose work is done."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column and its index."""
    op.add_column("jobs", sa.Column("due", sa.String(40)))
    op.create_index("ix_jobs_due", "jobs", ["due"])


def downgrade() -> None:
    """Drop them."""
    op.drop_index("ix_jobs_due", "jobs")
    op.drop_column("jobs", "due")
