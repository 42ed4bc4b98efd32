"""From recordings to muscles: what markers, ground forces and EMG of an experiment say of the body that made them.

`trial` holds what a laboratory records, `kinematics` finds the coordinates that fit markers best, `scaling` makes a
generic model one of a subject.

May import: all below, but for learning and its users.
To add: a step, as a module of one function from arrays to arrays; what it reads, in `trial`.
"""
