"""The resource: modal models."""
