"""Files of SCONE and Hyfydy: scenarios (.scone), models (.hfd) and optimised parameters (.par), and scenes from them.

`zml` reads the text that all but the last are written in, with the files that they include, as nodes that know their
lines; `numbers` has the notation of free numbers, `parameters` the files of their values. `model` makes bodies, joints,
muscles and contact of a .hfd, `controller` the gait states and reflexes of a scenario, `measures` its objective, and
`scenario` one scene of all.

May import: core, scene, formats.lines, formats.motion_table.
To add: a reflex of SCONE to `controller.REFLEXES`, a measure to `measures.MEASURES`, a part of a model to `model.PARTS`.
"""
