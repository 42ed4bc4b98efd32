"""How people judge a walk: contacts, cycles, angles against published norms, what the muscles did.

May import: core, kernels, scene, results, model.
To add: a measure in a module of its own, its line into `quality` and `table`.
"""
