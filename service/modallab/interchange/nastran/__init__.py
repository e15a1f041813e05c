"""Nastran bulk data: mass, stiffness and supports, converted to a structure."""
