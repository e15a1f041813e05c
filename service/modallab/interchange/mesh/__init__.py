"""Meshes of other programs, converted to structures with sections and materials from the caller."""
