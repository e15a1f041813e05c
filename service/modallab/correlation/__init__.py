"""How alike two sets of modes, or of responses, are."""
