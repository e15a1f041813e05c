"""The further test that tells rivals apart."""
