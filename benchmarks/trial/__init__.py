"""The blind trial in parts: rigs, hidden effects, cases, running them, scoring, tables."""
