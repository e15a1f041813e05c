"""Whitened residuals: logarithmic ratios of measurement to prediction over their random errors."""
