"""How surely a method finds what is wrong: tried again and again on modes of a known structure."""
