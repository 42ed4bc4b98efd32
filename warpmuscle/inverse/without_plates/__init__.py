"""Ground forces of motions that were recorded without force plates.

`contact_points` says where feet may touch the ground and how near to it they are, `ground_forces` shares what the
motion needs out among them.

May import: inverse and all below.
To add: a term of the cost to `ground_forces`, with its error beside plates in `docs`.
"""
