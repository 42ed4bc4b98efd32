"""Searches for parameters: candidates, their evaluation in batches, stages, replays of the best.

May import: core, kernels, search, scene, results, model, formats, simulation.
To add: a strategy in `warpmuscle.search`; what a search does between generations in `search_loop`.
"""
