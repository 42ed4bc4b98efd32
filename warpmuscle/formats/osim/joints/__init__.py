"""Classes of OpenSim's joints that are more than shifts along axes and turns about them.

May import: core, scene, formats.osim, formats.lines.
To add: a file for a class, whose row of turns and shifts `moves` takes in place of its axes.
"""
