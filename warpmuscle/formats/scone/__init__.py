"""Files of SCONE and Hyfydy: scenarios (.scone), models (.hfd) and optimised parameters (.par), and scenes from them.

`zml` reads the text that all but the last are written in, with the files that they include, as nodes that know their
lines; `numbers` has the notation of free numbers, `parameters` the files of their values. `model` makes bodies, muscles
and contact of a .hfd, with its `joints`, `controller` the gait states, patterns and noise of a scenario, `reflexes` its
reflexes, `start` how it begins, `measures` its objective, and `scenario` one scene of all. `write` gives free numbers
back in SCONE's names.

May import: core, kernels, scene, formats.lines, formats.osim.
To add: a controller of SCONE to `controller.CONTROLLERS`, a reflex to `reflexes.REFLEXES`, a measure to
`measures.MEASURES`, a law of Hyfydy to `model`.
"""
