"""The resource: structures."""
