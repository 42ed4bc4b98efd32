"""Markers on a body over time, and the angles of an arm that follow from them.

May import: core, synergy.
To add: a kind of file, as a reader in `files`; another limb, as a module beside `arm`.
"""
