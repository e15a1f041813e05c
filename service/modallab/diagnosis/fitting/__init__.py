"""The numbers of effects fitted to a measurement, with errors."""
