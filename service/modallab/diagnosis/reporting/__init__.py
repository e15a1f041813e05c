"""Report of a diagnosis: page, drawings, statements, summary."""
