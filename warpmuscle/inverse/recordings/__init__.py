"""Trials as motions of a scene, which figures, judgements, reports and the viewer take like simulated ones.

`motion` makes a `Recording` of a trial, and `result` the result file's part that has all of them.

May import: inverse and all below.
To add: a quantity that a recording of people has, to `motion.recorded_motion`.
"""
