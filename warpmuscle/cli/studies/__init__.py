"""Commands that hold what searches predict against what was measured.

May import: cli and all below.
To add: a command in a module of its own, its name in `cli.program`.
"""
