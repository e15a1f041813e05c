"""Names, labels and comments of what is stored."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns; a structure has the name that its description gives it."""
    op.add_column("things", sa.Column("name", sa.String(100), nullable=False, server_default=""))
    op.add_column("things", sa.Column("labels", sa.JSON(), nullable=False, server_default="[]"))
    op.add_column("things", sa.Column("comment", sa.Text(), nullable=False, server_default=""))
    things = sa.table("things", sa.column("kind"), sa.column("name"), sa.column("body", sa.JSON()))
    own_name = sa.func.substr(things.c.body["name"].as_string(), 1, 100)
    op.execute(
        things.update()
        .where(things.c.kind == "structure")
        .values(name=sa.func.coalesce(own_name, sa.literal("")))
    )


def downgrade() -> None:
    """Drop them."""
    for name in ("comment", "labels", "name"):
        op.drop_column("things", name)
