"""Modal models with modes dropped or merged by request, without a new extraction."""
