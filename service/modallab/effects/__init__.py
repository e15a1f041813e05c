"""Effects, one file each: physics, parameters, link to the hardware, signature."""

from modallab.core.registry import discover

discover(__name__, __path__)
