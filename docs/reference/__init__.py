"""Pages of the API reference, from docs/openapi.json."""
