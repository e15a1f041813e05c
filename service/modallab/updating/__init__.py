"""Model updating: correction coefficients of elements from measured modes."""
