"""Search for missing effects: screening, coarse fits, full fits, acceptance."""
