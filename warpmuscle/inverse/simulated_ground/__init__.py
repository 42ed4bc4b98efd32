"""Recorded motions that run forward on the ground of a simulation, without recorded forces and none at the root.

`foot_contact` puts spheres under the feet of a model, `floor_fit` puts the recording onto the ground, `windows`
simulates many short windows and how they change, `linear_quadratic` is the step of Gauss and Newton, `plan` a motion
near the recording that the ground carries, and `follow` its excitations; `ground_run` is what a trial adds to a result.

May import: inverse and all below.
To add: a law of contact to `foot_contact`, a term of the cost to `plan`.
"""
