"""Error location from one linear step: which coefficients a measurement speaks for."""
