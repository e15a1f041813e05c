"""The resource: diagnoses."""
