"""Unknown effects: an internal force or a channel's gain, solved for line by line."""
