"""Types of replies, generated from the service's OpenAPI document."""
