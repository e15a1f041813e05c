"""Projects: all things of an owner as one file."""
