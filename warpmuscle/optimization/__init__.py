"""Searches for parameters: candidates, their evaluation in batches, stages, replays of the best.

May import: everything listed before it in `docs/architecture.md`, down to core and search.
To add: a strategy in `warpmuscle.search`; what a search does between generations in `search_loop`.
"""
