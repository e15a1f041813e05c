"""Predictions of the spectra of one test or several from model, log book and effects."""
