"""What OpenSim's tools do otherwise than mechanics says, so that results can be compared with theirs.

`turned_axes` has the accelerations of bodies beyond a knee, and `differences` tells which way was taken, and by how
much the other one would change a result.

May import: inverse and all below.
To add: another difference, as a module that says where OpenSim has it, and an option of the step that leaves it out.
"""
