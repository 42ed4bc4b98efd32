"""Height fields of files, which become part of the scene that names them (`read`); `grey_png` reads pictures.

May import: core, scene, formats.
To add: a kind of file to `read`.
"""
