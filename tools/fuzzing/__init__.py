"""Mutated inputs of every kind that the command line reads, and what is demanded of it; see `tools/fuzz.py`."""
