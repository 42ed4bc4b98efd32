"""Questions put to one character: how robust, how steady, which moment arms, which muscle parameters fit.

May import: learning and all below.
To add: a study in a module of its own, its command in `warpmuscle.cli`.
"""
