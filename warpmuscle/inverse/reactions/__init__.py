"""What joints transmit while muscles pull: `joint_reactions` of recorded motions, `run_reactions` of simulated ones.

`joint_frames` reads where the joints of a model file have their frames.

May import: inverse and all below.
To add: another frame to show reactions in, to `joint_reactions`.
"""
