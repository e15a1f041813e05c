"""The resource: correlations."""
