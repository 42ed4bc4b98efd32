"""The command line.

May import: examples and all below.
To add: a command in a module of its own, its name in `program.COMMANDS`; a group of commands as a package, in
`program.GROUPS`; then run `tools/completion_table.py`, so that shells know its options.
"""
