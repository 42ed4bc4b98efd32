"""Motions to look at: in a browser with viser, live or replayed, or as one page that needs nothing but a browser."""
