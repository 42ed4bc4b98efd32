"""Animals from a short description: segments, joints, muscles by the boxes where they may attach, and a gait.

A description becomes an ordinary scene, of which attachments, wrapping radii, the muscles' properties and the
controller's numbers are free parameters; what a search found is judged by `judge`.

May import: core, search, synergy, markers, scene, results, model, formats, gait, simulation, optimization, studies.

To add: a kind of gait to `gait`; what a segment or muscle may say to `description`, and its check to `checks`.
"""
