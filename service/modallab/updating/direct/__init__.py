"""Direct methods: matrices, not coefficients, corrected or searched for errors in one go."""
