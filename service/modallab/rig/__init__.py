"""Virtual test rig: hardware and settings as declared, and simulated measurements."""
