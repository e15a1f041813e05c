"""A measurement in logarithms with its random errors, and what a prediction leaves of it."""
