"""The numbers that a fit may move: of effects, and within tolerances."""
