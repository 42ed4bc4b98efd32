"""A small creature: a trunk, two legs of one segment and a foot, three muscles a leg, one across both joints."""

import msgspec

from warpmuscle.creatures.description import Attachment, Bend, Creature, CreatureGait, CreatureMuscle, Segment


def small_creature() -> Creature:
    """It stands with its feet on the ground; its hips are at (+-0.1, 0.9, 0)."""
    segments = {
        "trunk": Segment(start=(0, 1.0, 0), end=(0, 1.4, 0.1), radius=0.1, mass=30),
        "Leg": Segment(
            start=(0.1, 0.9, 0), end=(0.1, 0.1, 0), radius=0.05, parent="trunk", joint="Hip", paired=True,
            range=(-0.8, 0.6),
        ),
        "Foot": Segment(
            start=(0.1, 0.03, -0.03), end=(0.1, 0.03, 0.12), at=(0.1, 0.08, 0), radius=0.03, parent="Leg",
            joint="Ankle", paired=True, box=True, mass=1, range=(-0.5, 0.5),
        ),
    }  # fmt: skip
    muscles = {
        "Back": CreatureMuscle(
            path=[
                Attachment(on="trunk", low=(0.1, 1.0, -0.1), high=(0.1, 1.1, -0.05)),
                Attachment(on="Leg", low=(0.1, 0.6, -0.05), high=(0.1, 0.7, -0.02), start=(0.1, 0.65, -0.02)),
            ],
            over=[Bend(joint="Hip", side="back", radius=(0.02, 0.06))], f_max=(500, 4500),
        ),
        "Front": CreatureMuscle(
            path=[
                Attachment(on="trunk", low=(0.08, 1.0, 0.05), high=(0.12, 1.1, 0.1)),
                Attachment(on="Leg", low=(0.1, 0.6, 0.02), high=(0.1, 0.7, 0.05)),
            ],
            f_max=(500, 4500),
        ),
        "Long": CreatureMuscle(
            path=[
                Attachment(on="trunk", low=(0.1, 0.95, -0.1), high=(0.1, 1.0, -0.05)),
                Attachment(on="Foot", low=(0.1, 0.03, -0.08), high=(0.1, 0.06, -0.03)),
            ],
            over=[Bend(joint="Ankle", side="back", radius=(0.02, 0.02))], f_max=(1000, 1000),
        ),
    }  # fmt: skip
    gait = CreatureGait(
        kind="walk", speed=1.0, time=0.5, hips="Hip", feet="Foot", level=["Ankle"], swing={"Hip": [-0.1, -0.4]},
        stance={"Ankle": [0.0, 0.1]}, start={"lHip": -0.2, "rHip": 0.2},
    )  # fmt: skip
    return Creature(name="small", segments=segments, muscles=muscles, gait=gait, density=1000)


def small_in_space() -> Creature:
    """The same in space: its hips turn to the sides, too, and have a muscle outside and one inside."""
    creature = small_creature()
    leg = msgspec.structs.replace(creature.segments["Leg"], side=(-0.3, 0.5))
    aside = {
        name: CreatureMuscle(
            path=[
                Attachment(on="trunk", low=(trunk, 1.0, -0.02), high=(trunk + 0.02, 1.1, 0.02)),
                Attachment(on="Leg", low=(thigh, 0.6, -0.02), high=(thigh + 0.02, 0.7, 0.02)),
            ],
            f_max=(500, 4500),
        )
        for name, trunk, thigh in (("Outer", 0.13, 0.13), ("Inner", 0.05, 0.05))
    }
    gait = msgspec.structs.replace(creature.gait, apart={"Hip": 0.05})
    return msgspec.structs.replace(
        creature, name="small_in_space", spatial=True, segments=creature.segments | {"Leg": leg},
        muscles=creature.muscles | aside, gait=gait,
    )  # fmt: skip
