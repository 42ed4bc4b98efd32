"""What the command from recordings to muscles reads.

May import: cli and all below.
To add: an option that reads files, as a function in `inputs`.
"""
