"""Averages of single-FRF fits over FRFs, their checks, and flags and notes on modes."""
