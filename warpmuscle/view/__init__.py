"""Motions to look at: in a browser with viser, live or replayed, or as one page that needs nothing but a browser.

May import: simulation and all below.
To add: what is drawn of a moment to `instances` for viser, and to `assets` for the page; a plot to `curves`.
"""
