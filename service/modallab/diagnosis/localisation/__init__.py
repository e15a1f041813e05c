"""Localisation of the disagreement between measurement and model, in numbers and statements."""
