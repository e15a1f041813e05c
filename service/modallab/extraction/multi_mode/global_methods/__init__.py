"""Global methods, one module each; every module registers its method in `GLOBAL_METHODS`."""

from modallab.core.registry import discover

discover(__name__, __path__)
