"""Least-squares fits of effects, and the covariance of the fitted parameters."""
