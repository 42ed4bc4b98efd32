"""What scripts and notebooks begin with: a table of scenes, a run in one line, and what can be done with it.

May import: report, video and all below.
To add: a first line of Python here, and its name in `warpmuscle/__init__.py`.
"""
