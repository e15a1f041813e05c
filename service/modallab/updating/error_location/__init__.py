"""Error location by one linear step of the coefficients."""
