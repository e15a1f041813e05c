"""One mode from a window of one FRF, for many windows at once."""
