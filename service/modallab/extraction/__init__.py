"""Extraction of modes from frequency response functions: bands, single-mode and multi-mode fits, averages."""
