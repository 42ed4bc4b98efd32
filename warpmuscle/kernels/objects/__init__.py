"""Objects: rigid bodies beside the character that move freely, are held, or are fixed, and touch ground and bodies.

May import: kernels.
To add: a shape to `shape`, a force between bodies and objects to `touch`; `stage` has all of it in order.
"""
