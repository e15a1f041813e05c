"""Spectral estimation: time records to spectra, spectra to FRFs with coherence and random errors."""
