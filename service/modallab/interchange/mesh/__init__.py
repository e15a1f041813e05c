"""Meshes of other programs: cells with what the caller says they are made of, as a structure."""
