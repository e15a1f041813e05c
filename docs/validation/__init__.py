"""The validation report: every published table beside the same numbers from this code."""
