"""A second simulator of modal tests, which shares no line with the package: other matrices, other routes."""
