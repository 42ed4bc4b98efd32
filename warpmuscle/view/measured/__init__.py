"""Markers and forces that were measured, beside the body that moves.

May import: view and all below.
To add: what else was measured of a trial to `content`, and how it is drawn to `assets/measured.js`.
"""
