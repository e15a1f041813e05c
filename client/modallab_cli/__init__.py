"""The command line: a client of a lab beside this process or elsewhere; files in, tables and pictures out."""
