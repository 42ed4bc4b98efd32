"""Numbers of a scene that are edited while it runs: which there are (`numbers`), and their `names` and sliders.

May import: core, scene, view.controls, view.packing.
To add: what a part of the controller is called to `names`.
"""
