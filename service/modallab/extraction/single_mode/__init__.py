"""Single-mode methods: one mode from a window of one FRF, for many windows in one call."""
