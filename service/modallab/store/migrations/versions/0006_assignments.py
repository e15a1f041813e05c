"""Assignments, their trials and the answers to them."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the tables."""
    op.create_table(
        "assignments",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("class_id", sa.String(64), nullable=False),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("structure_id", sa.String(64), nullable=False),
        sa.Column("created", sa.String(40), nullable=False),
        sa.Column("closed", sa.String(40)),
        sa.Column("secret", sa.String(64), nullable=False),
        sa.Column("body", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(["class_id"], ["classes.id"], name=op.f("fk_assignments_class_id")),
        sa.ForeignKeyConstraint(["structure_id"], ["things.id"], name=op.f("fk_assignments_structure_id")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_assignments")),
    )
    op.create_index(op.f("ix_assignments_class_id"), "assignments", ["class_id"])
    op.create_index(op.f("ix_assignments_structure_id"), "assignments", ["structure_id"])
    op.create_table(
        "trials",
        sa.Column("assignment_id", sa.String(64), nullable=False),
        sa.Column("student", sa.String(64), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("request_key", sa.String(128)),
        sa.Column("measurement_id", sa.String(64)),
        sa.ForeignKeyConstraint(["assignment_id"], ["assignments.id"], name=op.f("fk_trials_assignment_id")),
        sa.ForeignKeyConstraint(["measurement_id"], ["things.id"], name=op.f("fk_trials_measurement_id")),
        sa.PrimaryKeyConstraint("assignment_id", "student", "number", name=op.f("pk_trials")),
    )
    op.create_index(op.f("ix_trials_measurement_id"), "trials", ["measurement_id"], unique=True)
    op.create_table(
        "submissions",
        sa.Column("assignment_id", sa.String(64), nullable=False),
        sa.Column("student", sa.String(64), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("created", sa.String(40), nullable=False),
        sa.Column("answer", sa.JSON(), nullable=False),
        sa.Column("marks", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(
            ["assignment_id"], ["assignments.id"], name=op.f("fk_submissions_assignment_id")
        ),
        sa.PrimaryKeyConstraint("assignment_id", "student", "number", name=op.f("pk_submissions")),
    )


def downgrade() -> None:
    """Drop them."""
    for table in ("submissions", "trials", "assignments"):
        op.drop_table(table)
