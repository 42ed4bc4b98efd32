"""What motions are worth, and what ends them.

May import: kernels.

To add: a term's function, and the term to `objective_terms`.
"""
