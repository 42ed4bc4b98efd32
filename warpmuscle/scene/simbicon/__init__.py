"""SIMBICON's part of a scene: its types, and what is checked of them that types cannot.

Its kernels are `control/simbicon.py` and what that imports, its arrays on a device `model/controllers/simbicon.py`, and
what is recorded of it `results/simbicon.py`.

May import: core, kernels, scene.
To add: a key of the controller is a field in `controller.py`, its check in `checks.py`.
"""
