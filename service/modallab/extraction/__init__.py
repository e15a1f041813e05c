"""Modes out of frequency responses: bands, single-mode fits, one consistent set."""
