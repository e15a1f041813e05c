"""Rounding floors of double precision: below them a number is arithmetic, not physics.

All are relative to the size of what they are compared with unless they say otherwise. They follow from the
53 bits of a double and from how errors grow in the operation that is named; none is tuned.
"""

SQUARE_ROUNDING = 1e-16  # of a power spectrum: the square of what a Fourier transform leaves
UNIT_ROUNDING = 1e-15  # of values of order one after a few operations
SUM_ROUNDING = 1e-14  # of a sum of many products, against its largest term
EIGENVALUE_ROUNDING = 1e-13  # of an eigenvalue of a well-conditioned matrix
PRODUCT_ROUNDING = 1e-12  # of a product of matrices, against its largest entry
SOLUTION_ROUNDING = 1e-11  # of the right-hand side, left by the solution of a linear system
CURVATURE_ROUNDING = 1e-10  # of unit normal equations: below it, columns are linearly dependent
COMPARISON_ROUNDING = 1e-9  # of two numbers that are equal but for the order of operations
COHERENCE_ROUNDING = 1e-8  # of a response: incoherent power below its square is rounding

SAFE_DIVISOR = 1e-300  # absolute: keeps a quotient finite where the divisor may be zero
SAFE_SQUARED_DIVISOR = 1e-100  # absolute: the same where the divisor is squared or cubed
COMPLEX_STEP = 1e-30  # relative: complex-step derivatives cancel nothing, so the step may be this small
