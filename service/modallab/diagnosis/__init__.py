"""Find where a measurement and its model part, name the missing effect, add it, show the gap shrink."""
