"""Formats of files with FRFs, one file each: how a format is recognised, and its reader.

The libraries of a format are imported when a file of it is read: each file is read by a process of its own,
which should start fast.
"""

from modallab.core.registry import discover

discover(__name__, __path__)
