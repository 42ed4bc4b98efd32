"""EMG-driven muscles: moments from measured EMG, and parameters of muscles that moments of recordings identify.

`calibrate` searches the parameters, `parameters` says which there are and within which bounds, and `moments` evaluates
many sets of them at once.

May import: inverse and all below.
To add: a parameter to `parameters.Bounds` and to `kernels.inverse.emg_driven.Candidates`.
"""
