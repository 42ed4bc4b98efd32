"""What laboratories write into C3D files beside markers: force plates, axes of the room, raw EMG.

`wrench` has the kinds of plates and turns their channels into force and moment, `c3d_plates` makes loads of them in
ground axes, `axes` finds which way is up, and `raw_emg` makes envelopes.

May import: inverse and all below.
To add: a kind of plate, in `wrench`, with a file of known forces in its test.
"""
