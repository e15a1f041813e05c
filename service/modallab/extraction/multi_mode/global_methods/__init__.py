"""One file a method; each registers itself in `GLOBAL_METHODS`."""

from modallab.core.registry import discover

discover(__name__, __path__)
