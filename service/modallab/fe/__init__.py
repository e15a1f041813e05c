"""Finite elements: structures, their assembly and their dynamics."""
