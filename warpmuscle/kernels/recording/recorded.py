"""What frames hold of a muscle, by its place in `structs.Record.muscle`; without Warp, for those who read results."""

PATH_LENGTH, FIBRE_LENGTH, FIBRE_VELOCITY, DESIRED_FORCE, EXCITATION, ACTIVATION, FORCE = range(7)
MUSCLE_PLACES = 7
