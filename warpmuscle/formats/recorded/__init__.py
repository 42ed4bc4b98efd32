"""What scenes take from recordings as they are read: where a simulation starts (`start`).

May import: core, scene, results.
To add: another part of a scene that a motion can say, as a module of its own, called by `formats.toml`.
"""
