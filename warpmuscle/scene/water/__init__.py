"""Water: what a scene says of it (`part`), and which capsules bodies are in it (`capsules`).

May import: core, scene.
To add: a number to `Water`, its check to `scene.validation.water`; `kernels/water/section.py` has the forces.
"""
