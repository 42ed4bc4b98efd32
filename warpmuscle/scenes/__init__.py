"""Ready-to-run scenes, one TOML file each, and the characters that they share.

May import: nothing.

To add: a TOML file, with a description of what it is good for.
"""
