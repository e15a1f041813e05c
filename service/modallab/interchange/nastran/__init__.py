"""Nastran bulk data: what it holds of mass and stiffness, as a structure."""
