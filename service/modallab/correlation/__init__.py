"""Correlation of two sets of modes, or of frequency response functions."""
