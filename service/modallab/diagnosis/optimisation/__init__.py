"""Parameters of effects and nuisance parameters in least squares: coordinates, bounds, derivatives, steps."""
