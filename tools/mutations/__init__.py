"""Small changes of the source, and which tests see them; `tools/mutate.py` runs them."""
