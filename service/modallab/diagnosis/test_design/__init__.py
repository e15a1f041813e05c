"""Design of the further test that distinguishes rival explanations."""
