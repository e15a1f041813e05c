"""Methods of error location, one file each."""

from modallab.core.registry import discover

discover(__name__, __path__)
