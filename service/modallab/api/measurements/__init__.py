"""The resource: measurements."""
