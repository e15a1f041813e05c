"""Preprocessing before any fit: FRFs with their random errors, bands, windows of lines, leakage."""
