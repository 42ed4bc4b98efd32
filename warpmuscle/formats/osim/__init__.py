"""OpenSim model files: what they say, as records with line numbers, and scenes from that.

`elements` parses XML within bounds, `upgrade` brings old layouts into that of version 4, `properties` reads values with
the defaults of their classes, and `read` makes records of them. `build` makes a scene of records. What is not used is
noted with its line and with what follows from that.

May import: core, scene, formats.lines.
To add: a class of OpenSim to the table of its kind (`joints.MOTIONS`, `muscles.CLASSES`), its element to a record.
"""
