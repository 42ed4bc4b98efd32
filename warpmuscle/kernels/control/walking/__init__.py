"""Generalised walking of Coros, Beaudoin, van de Panne 2010: feet placed by an inverted pendulum, virtual forces.

May import: kernels.
To add: an equation on plain values in the file of its topic, its number to `parameters.py`, and the call in `plan.py`
(what is wanted) or `torques.py` (which torques make it).
"""
