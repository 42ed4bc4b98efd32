"""Triangles from files: VTK's `.vtp`, `.stl` and `.obj`, as models of OpenSim are drawn with.

May import: scene, core.
To add: a format to a file of its own, and its suffix to `read.FORMATS`.
"""
