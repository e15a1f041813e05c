"""Where model and measurement part, as numbers and in words."""
