"""Points of a sweep that follow from the results of others.

May import: sweep and all below.
To add: another way to choose in `choice`; what a point is worth in `rounds`.
"""
