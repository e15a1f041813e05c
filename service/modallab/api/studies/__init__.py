"""The resource: studies."""
