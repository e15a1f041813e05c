"""When stored things were deleted that can still be restored."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column and its index."""
    op.add_column("things", sa.Column("removed", sa.String(40)))
    op.create_index("ix_things_removed", "things", ["removed"])


def downgrade() -> None:
    """Drop them; what is in the trash is there again."""
    op.drop_index("ix_things_removed", "things")
    op.drop_column("things", "removed")
