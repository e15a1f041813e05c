"""What the lines tell before any fit: responses with their errors, bands, windows, leakage."""
