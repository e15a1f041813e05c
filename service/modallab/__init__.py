"""modallab: a simulated modal-testing lab as a service."""

from importlib.metadata import version

__version__ = version("modallab")
