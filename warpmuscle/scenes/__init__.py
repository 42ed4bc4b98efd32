"""Ready-to-run scenes, one TOML file each, a folder for each study; what several share is in `characters`.

May import: nothing.

To add: a TOML file in the folder of its study, with a description of what it is good for; a new folder is named in
`core.shipped.STUDIES`. Names are unique among all folders: a scene is found by its name.
"""
