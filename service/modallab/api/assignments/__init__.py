"""The resource: assignments."""
