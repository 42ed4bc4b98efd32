"""The throwing arm: muscles and synergies fitted to recorded motions, replayed, and used for new throws.

May import: plots and all below.
To add: a column of motion files to `recordings.motion_files`; a way to solve a fit beside `follow`.
"""
