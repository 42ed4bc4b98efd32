"""Ground that moves along itself: what a scene says of a treadmill or platform (`part`), and how far it has gone.

May import: core, scene.
To add: a number to `Treadmill`, its check to `scene.validation.treadmill`; `kernels/contact/belts.py` moves the ground.
"""
