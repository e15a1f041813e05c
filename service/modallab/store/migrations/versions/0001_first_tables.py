"""The first tables: things, what they were made from, truths, jobs."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the tables."""
    op.create_table(
        "things",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("kind", sa.String(32), nullable=False),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("created", sa.String(40), nullable=False),
        sa.Column("version", sa.String(32), nullable=False),
        sa.Column("inputs", sa.JSON(), nullable=False),
        sa.Column("seed", sa.BigInteger()),
        sa.Column("body", sa.JSON(), nullable=False),
        sa.Column("arrays_hash", sa.String(64)),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_things")),
    )
    op.create_index("ix_things_shelf", "things", ["kind", "owner", "created", "id"])
    op.create_table(
        "links",
        sa.Column("source", sa.String(64), nullable=False),
        sa.Column("target", sa.String(64), nullable=False),
        sa.ForeignKeyConstraint(["source"], ["things.id"], name=op.f("fk_links_source"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["target"], ["things.id"], name=op.f("fk_links_target")),
        sa.PrimaryKeyConstraint("source", "target", name=op.f("pk_links")),
    )
    op.create_index(op.f("ix_links_target"), "links", ["target"])
    op.create_table(
        "truths",
        sa.Column("measurement_id", sa.String(64), nullable=False),
        sa.Column("structure_id", sa.String(64), nullable=False),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("body", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(
            ["measurement_id"], ["things.id"], name=op.f("fk_truths_measurement_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(["structure_id"], ["things.id"], name=op.f("fk_truths_structure_id")),
        sa.PrimaryKeyConstraint("measurement_id", name=op.f("pk_truths")),
    )
    op.create_index(op.f("ix_truths_structure_id"), "truths", ["structure_id"])
    op.create_table(
        "jobs",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("task", sa.String(64), nullable=False),
        sa.Column("arguments", sa.JSON(), nullable=False),
        sa.Column("created", sa.String(40), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("fraction", sa.Float(), nullable=False),
        sa.Column("message", sa.Text(), nullable=False),
        sa.Column("result_id", sa.String(64), nullable=False),
        sa.Column("error", sa.JSON(none_as_null=True)),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_jobs")),
    )
    op.create_index(op.f("ix_jobs_state"), "jobs", ["state"])


def downgrade() -> None:
    """Drop the tables."""
    for table in ("jobs", "truths", "links", "things"):
        op.drop_table(table)
