"""Rules from goals to signals: learned from throws that meet goals, kept in files, gone on with from there.

May import: throw and all below.
To add: another way from goals to signals beside `learned` in `rule`; what a file keeps to `rule_file`.
"""
