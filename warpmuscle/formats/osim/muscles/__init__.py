"""Classes of muscles that OpenSim no longer recommends, and what stands in for them; tensions that are expressions.

May import: core, scene, formats.osim, formats.lines.
To add: a class of muscles to `stand_ins.STOOD_FOR`, and its curves' defaults to `old_curves`.
"""
