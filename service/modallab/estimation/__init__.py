"""From records to spectra, from spectra to FRFs with coherence and random errors."""
