"""Bodies of the requests that described stored things."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; of what is stored already nothing is known."""
    op.add_column("things", sa.Column("request", sa.JSON))


def downgrade() -> None:
    """Drop it."""
    op.drop_column("things", "request")
