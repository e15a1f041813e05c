"""A diagnosis as a page, pictures and words."""
