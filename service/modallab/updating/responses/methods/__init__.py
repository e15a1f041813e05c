"""Updating methods that take frequency responses, one file each."""

from modallab.core.registry import discover

discover(__name__, __path__)
