"""The virtual test rig: what a log book declares, and what a measurement makes of a structure."""
