"""Motions to look at: as one page that needs nothing but a browser, replayed or live.

May import: inverse and all below.
To add: what is drawn of a body to `figure`, and of a moment to `assets/biped.js`; a curve to `curves`; what can be
moved live to `controls`.
"""
