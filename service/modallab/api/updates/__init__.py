"""The resource: updates."""
