"""Fits of many FRFs made into one set of modes, and what is said about it."""
