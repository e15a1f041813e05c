"""The resource: rigs."""
