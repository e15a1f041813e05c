"""Examples of the OpenAPI document, each a request that works."""

from typing import Any

from fastapi import Body


def example(body: dict[str, Any]) -> Any:
    """Return the declaration of a request body with its example."""
    return Body(openapi_examples={"example": {"value": body}})


def examples(**bodies: dict[str, Any]) -> Any:
    """Return the declaration of a request body with named examples."""
    return Body(openapi_examples={name: {"value": body} for name, body in bodies.items()})
