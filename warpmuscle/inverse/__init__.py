"""From recordings to muscles: what markers, ground forces and EMG of an experiment say of the body that made them.

`trial` holds what a laboratory records, `kinematics` finds the coordinates that fit markers best, `scaling` makes a
generic model one of a subject. `dynamics` says which moments a motion needs, `static_optimization` which muscles make
them, `reactions` what joints carry then; `tracking` lets a simulation follow the motion, and
`emg_driven` identifies muscles by EMG. `body_model` evaluates a
model in many frames at once for them, and `output` writes what they found.

May import: studies and all below.
To add: a step, as a module of one function from arrays to arrays; what it reads, in `trial`.
"""
