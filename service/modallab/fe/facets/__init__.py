"""Ready-made structures, one file each."""

from modallab.core.registry import discover

discover(__name__, __path__)
