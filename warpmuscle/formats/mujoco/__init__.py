"""Scenes from MuJoCo's models, as its own compiler reads them.

`compiled` lets the `mujoco` package compile a file, after a look at what it names; `reference` has the model in a pose
in which all hinges and slides are at 0, in our axes; `skeleton`, `tendons`, `muscles`, `springs` and `contact` make
parts of a scene of that, and `build` puts them together. What is not kept is noted.

May import: core, scene, formats.lines, formats.mjcf_text, formats.osim.
To add: what else a scene can hold of a model to the file of its kind; what it can not to `lost`.
"""
