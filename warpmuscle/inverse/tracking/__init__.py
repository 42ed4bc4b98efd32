"""Computed muscle control: simulations that follow recordings, and the excitations with which they do.

`track` is the loop over windows of time, `driven_body` the simulation of all trials, `force_sharing` the static
optimisation within a window, `state_difference` what is between two states, `timed_forces` what of a model does not
act meanwhile, and `tracked` what was found.

May import: inverse and all below.
To add: what a trial's result should hold to `tracked`, an option to `track.TrackingOptions`.
"""
