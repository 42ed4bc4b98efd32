"""Damages of recordings that people meet, and what must be said about each; `tools/damage.py` runs them."""
